/* SPDX-License-Identifier: MIT
 * Atomic output files. */
#define _POSIX_C_SOURCE 200809L
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "say.h"

static char* concatenate(const char* a, const char* b, const char* c) {
    const size_t size = strlen(a) + strlen(b) + strlen(c) + 1;
    char* text = malloc(size);
    if (text == NULL) {
        (void)say_no_memory();
        return NULL;
    }
    (void)snprintf(text, size, "%s%s%s", a, b, c);
    return text;
}

char* output_path(const char* folder, const char* name) {
    return concatenate(folder, "/", name);
}

int output_folder(const char* folder, int* created) {
    struct stat found;
    *created = 0;
    if (mkdir(folder, 0777) == 0) {
        *created = 1;
    } else if (errno != EEXIST) {
        say("cannot make the folder %s: %s", folder, strerror(errno));
        return FAILED;
    }
    if (stat(folder, &found) != 0 || !S_ISDIR(found.st_mode)) {
        say("cannot write to %s: it is not a folder", folder);
        return FAILED;
    }
    if (access(folder, W_OK | X_OK) != 0) {
        say("cannot write to the folder %s: %s", folder, strerror(errno));
        return FAILED;
    }
    return DONE;
}

void output_remove(const char* folder, const char* name) {
    char* path = output_path(folder, name);
    if (path != NULL) (void)unlink(path);
    free(path);
}

static void release(output_file* file) {
    free(file->path);
    free(file->partial);
    memset(file, 0, sizeof *file);
}

int output_open(output_file* file, const char* folder, const char* name) {
    int descriptor;
    memset(file, 0, sizeof *file);
    file->path = output_path(folder, name);
    if (file->path != NULL) file->partial = concatenate(file->path, ".part", "");
    if (file->partial == NULL) {
        release(file);
        return FAILED;
    }
    /* What an ended run has left, or whatever else stands there, is not written through but replaced. */
    (void)unlink(file->partial);
    descriptor = open(file->partial, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    file->stream = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    if (file->stream == NULL) {
        say("cannot write %s: %s", file->partial, strerror(errno));
        if (descriptor >= 0) (void)close(descriptor);
        release(file);
        return FAILED;
    }
    return DONE;
}

/* A rename is on the disk only when its folder is. Some file systems cannot synchronise a folder; they are believed. */
static void synchronise_folder_of(const char* path) {
    char* folder = concatenate(path, "", "");
    char* slash = folder != NULL ? strrchr(folder, '/') : NULL;
    if (slash != NULL) {
        int descriptor;
        slash[slash == folder] = '\0';
        descriptor = open(folder, O_RDONLY);
        if (descriptor >= 0) {
            (void)fsync(descriptor);
            (void)close(descriptor);
        }
    }
    free(folder);
}

int output_commit(output_file* file) {
    int error = 0;
    /* A stream that failed earlier no longer knows why; EIO is then the honest answer if nothing better comes up. */
    if (ferror(file->stream)) error = EIO;
    errno = 0;
    if (fflush(file->stream) != 0) error = errno;
    if (error == 0 && fsync(fileno(file->stream)) != 0 && errno != EINVAL && errno != ENOTSUP) error = errno;
    if (fclose(file->stream) != 0 && error == 0) error = errno;
    file->stream = NULL;
    if (error == 0 && rename(file->partial, file->path) != 0) error = errno;
    if (error != 0) {
        say("cannot write %s: %s", file->path, error == EIO ? "the disk is full or failing" : strerror(error));
        (void)unlink(file->partial);
    } else {
        synchronise_folder_of(file->path);
    }
    release(file);
    return error == 0 ? DONE : FAILED;
}

void output_discard(output_file* file) {
    if (file->stream != NULL) (void)fclose(file->stream);
    if (file->partial != NULL) (void)unlink(file->partial);
    release(file);
}
