// SPDX-License-Identifier: MIT
#include "grid/error.hpp"

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <vector>

namespace dqa {
namespace {

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

struct Sink {
    std::mutex mutex;
    LogHandler handler = nullptr;
    std::int32_t level = 0;
    void* user_data = nullptr;
};

Sink& sink() {
    static Sink instance;
    return instance;
}

}  // namespace

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

void set_log_handler(LogHandler handler, std::int32_t level, void* user_data) {
    Sink& s = sink();
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.handler = handler;
    s.level = handler ? level : 0;
    s.user_data = user_data;
}

void log_message(std::int32_t level, const char* pattern, ...) {
    Sink& s = sink();
    LogHandler handler = nullptr;
    void* user_data = nullptr;
    {
        const std::lock_guard<std::mutex> lock(s.mutex);
        if (level > s.level) return;
        handler = s.handler;
        user_data = s.user_data;
    }
    va_list args;
    va_start(args, pattern);
    const std::string text = vformat(pattern, args);
    va_end(args);
    if (handler) handler(level, text.c_str(), user_data);  // outside the lock: a handler may call the library
}

}  // namespace dqa
