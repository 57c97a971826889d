/* SPDX-License-Identifier: MIT
 * The best design as files. */
#include "results.h"

#include <stdlib.h>

#include "output.h"
#include "say.h"
#include "stl.h"
#include "vtu.h"

static int write_controller(const scene* s, const char* folder) {
    char* path = output_path(folder, CONTROLLER_FILE);
    const int outcome =
        path != NULL ? say_status(dqa_controller_save(s->controller, path), "save the controller") : FAILED;
    free(path);
    return outcome;
}

int results_write(const scene* s, const motion* m, const char* folder) {
    int outcome = stl_write(folder, DESIGN_FILE, motion_frame(m, 0), m->triangles, m->n_triangles);
    if (outcome == DONE) outcome = write_controller(s, folder);
    return outcome == DONE ? vtu_write_motion(m, folder) : outcome;
}
