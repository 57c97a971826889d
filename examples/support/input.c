/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "input.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "say.h"

FILE* input_open(const char* path) {
    struct stat found;
    FILE* stream = NULL;
    /* Without O_NONBLOCK a pipe would be waited for before it can be told from a file. */
    const int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    int error = descriptor < 0 ? errno : 0;
    if (error == 0 && fstat(descriptor, &found) != 0) error = errno;
    if (error == 0 && !S_ISREG(found.st_mode)) {
        say("cannot read %s: it is not a regular file", path);
        (void)close(descriptor);
        return NULL;
    }
    if (error == 0) {
        stream = fdopen(descriptor, "rb");
        if (stream == NULL) error = errno;
    }
    if (stream == NULL) {
        if (descriptor >= 0) (void)close(descriptor);
        say("cannot read %s: %s", path, strerror(error));
    }
    return stream;
}
