/* SPDX-License-Identifier: MIT
 * Where the shapes that come with the examples lie. */
#define _POSIX_C_SOURCE 200809L
#include "shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "say.h"

/* Two ways to be an eel, a shark and a goldfish: different enough that the optimiser has a choice, and swimmers all of
 * them. Stiffer hulls (tuna, clownfish) hardly swim by one muscle, and a mixture with much of them is a local optimum.
 */
static const char* const names[] = {"eel_vertical.stl", "eel_horizontal.stl", "hammerhead.stl", "goldfish_comet.stl"};

const char* const shapes_twelve[] = {"great_white.stl",
                                     "hammerhead.stl",
                                     "thresher.stl",
                                     "whale_shark.stl",
                                     "goldfish_common.stl",
                                     "goldfish_comet.stl",
                                     "goldfish_fantail.stl",
                                     "goldfish_ryukin.stl",
                                     "goldfish_oranda.stl",
                                     "goldfish_ranchu.stl",
                                     "goldfish_telescope.stl",
                                     "submarine.stl",
                                     NULL};

int32_t shapes_count(void) {
    return (int32_t)(sizeof names / sizeof names[0]);
}

static int readable(const char* folder, const char* name, char* path, size_t size) {
    const int length = snprintf(path, size, "%s/%s", folder, name);
    return length > 0 && (size_t)length < size && access(path, R_OK) == 0;
}

/* The folder of the running program; "" where the system does not tell. */
static void executable_folder(char* folder, size_t size) {
    const ssize_t length = readlink("/proc/self/exe", folder, size - 1);
    char* slash;
    folder[length > 0 ? (size_t)length : 0] = '\0';
    slash = strrchr(folder, '/');
    if (slash != NULL) *slash = '\0';
}

/* Looks wherever the shapes may lie if the user has named no folder. */
static int find(const char* name, char* path, size_t size) {
    static const char* const beside[] = {"shapes", "../share/diffaqua/shapes"};
    char folder[2048], place[3072];
    executable_folder(folder, sizeof folder);
    for (size_t i = 0; i < sizeof beside / sizeof beside[0]; ++i) {
        (void)snprintf(place, sizeof place, "%s/%s", folder, beside[i]);
        if (readable(place, name, path, size)) return 1;
    }
    return 0;
}

char* shapes_path(int32_t index) {
    return shapes_named(names[index]);
}

int shapes_has(const char* name) {
    const char* chosen = getenv("DQA_SHAPES_DIR");
    char path[4096];
    return chosen != NULL && *chosen != '\0' ? readable(chosen, name, path, sizeof path)
                                             : find(name, path, sizeof path);
}

char* shapes_named(const char* name) {
    const char* chosen = getenv("DQA_SHAPES_DIR");
    char path[4096];
    char* copy;
    if (chosen != NULL && *chosen != '\0') {
        if (!readable(chosen, name, path, sizeof path)) {
            say("cannot read %s in the folder %s named by DQA_SHAPES_DIR", name, chosen);
            return NULL;
        }
    } else if (!find(name, path, sizeof path)) {
        say("cannot find the shipped shape %s; name its folder in the environment variable DQA_SHAPES_DIR", name);
        return NULL;
    }
    copy = strdup(path);
    if (copy == NULL) (void)say_no_memory();
    return copy;
}
