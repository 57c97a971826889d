/* SPDX-License-Identifier: MIT
 * What the program runs on. */
#define _POSIX_C_SOURCE 200809L
#include "machine.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

void machine_processor(char* name, size_t size) {
    static const char key[] = "model name";
    char line[512];
    FILE* stream = fopen("/proc/cpuinfo", "r");
    (void)snprintf(name, size, "unknown");
    if (stream == NULL) return;
    while (fgets(line, sizeof line, stream) != NULL) {
        const char* value = strchr(line, ':');
        if (strncmp(line, key, sizeof key - 1) != 0 || value == NULL) continue;
        line[strcspn(line, "\n")] = '\0';
        value += strspn(value, ": \t");
        (void)snprintf(name, size, "%s", value);
        break;
    }
    (void)fclose(stream);
}

long machine_processors(void) {
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? online : 1;
}
