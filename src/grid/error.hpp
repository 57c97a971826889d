// SPDX-License-Identifier: MIT
// Errors of every room: one list of codes with name and text (capi/ freezes their numbers), and one exception type.
#pragma once

#include <cstdarg>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace dqa {

// X(name, value, text)
#define DQA_STATUS_LIST(X)                                                            \
    X(SUCCESS, 0, "success")                                                          \
    X(ERROR_ARGUMENT, -1, "an argument is out of its range")                          \
    X(ERROR_STATE, -2, "the call does not fit the state of the object")               \
    X(ERROR_FILE, -3, "a file's content is not what was expected")                    \
    X(ERROR_IO, -4, "a file could not be opened, read or written")                    \
    X(ERROR_MESH, -5, "a mesh is open, inconsistently oriented, empty or not finite") \
    X(ERROR_MEMORY, -6, "out of memory")                                              \
    X(ERROR_UNSUPPORTED, -7, "this build or version of the library cannot do it")     \
    X(NOT_CONVERGED, -8, "an iteration stopped above its tolerance")                  \
    X(DIVERGED, -9, "a state became non-finite")                                      \
    X(CANCELLED, -10, "cancelled by a callback or a cancel token")                    \
    X(ERROR_INTERNAL, -11, "internal error: a defect of the library")

enum class Status : std::int32_t {
#define DQA_X(name, value, text) name = value,
    DQA_STATUS_LIST(DQA_X)
#undef DQA_X
};

class Error : public std::runtime_error {
public:
    Error(Status status, const std::string& message) : std::runtime_error(message), status_(status) {}
    Status status() const noexcept { return status_; }

private:
    Status status_;
};

// printf-style formatting, so that messages read in one piece at the place where they are thrown.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));
std::string vformat(const char* pattern, va_list args);

[[noreturn]] void fail(Status status, const char* pattern, ...) __attribute__((format(printf, 2, 3)));

}  // namespace dqa
