// SPDX-License-Identifier: MIT
#include "grid/error.hpp"

#include <cstdarg>
#include <cstdio>
#include <vector>

namespace dqa {

std::string vformat(const char* pattern, va_list args) {
    va_list copy;
    va_copy(copy, args);
    const int length = std::vsnprintf(nullptr, 0, pattern, copy);
    va_end(copy);
    if (length < 0) return pattern;
    std::vector<char> buffer(static_cast<std::size_t>(length) + 1);
    std::vsnprintf(buffer.data(), buffer.size(), pattern, args);
    return std::string(buffer.data());
}

std::string format(const char* pattern, ...) {
    va_list args;
    va_start(args, pattern);
    std::string text = vformat(pattern, args);
    va_end(args);
    return text;
}

void fail(Status status, const char* pattern, ...) {
    va_list args;
    va_start(args, pattern);
    const std::string text = vformat(pattern, args);
    va_end(args);
    throw Error(status, text);
}

}  // namespace dqa
