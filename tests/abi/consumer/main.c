/* SPDX-License-Identifier: MIT
 * Built against an installed library: the version is the expected one, header and library agree, and a call works. */
#include <diffaqua.h>
#include <stdio.h>
#include <string.h>

int main(int argc, char** argv) {
    double x[2] = {2.0, 0.0};
    if (argc != 2 || strcmp(dqa_version(), argv[1]) != 0) {
        fprintf(stderr, "version %s\n", dqa_version());
        return 1;
    }
    if (dqa_abi_version() != DQA_ABI_VERSION) return 1;
    if (dqa_project_simplex(x, 2) != DQA_SUCCESS || x[0] != 1.0 || x[1] != 0.0) {
        fprintf(stderr, "projection gave %g, %g: %s\n", x[0], x[1], dqa_last_error());
        return 1;
    }
    printf("diffaqua %s (%s)\n", dqa_version(), dqa_features());
    return 0;
}
