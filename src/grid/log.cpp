// SPDX-License-Identifier: MIT
#include "grid/log.hpp"

#include <atomic>
#include <cstdarg>
#include <mutex>

#include "grid/error.hpp"

namespace dqa {
namespace {

struct Sink {
    std::mutex mutex;
    std::atomic<std::int32_t> level{0};
    LogHandler handler = nullptr;
    void* user_data = nullptr;
};

Sink& sink() {
    static Sink instance;
    return instance;
}

}  // namespace

void set_log_handler(LogHandler handler, std::int32_t level, void* user_data) {
    Sink& s = sink();
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.handler = handler;
    s.level = handler ? level : 0;
    s.user_data = user_data;
}

void log_message(LogLevel level, const char* pattern, ...) noexcept {
    Sink& s = sink();
    const std::int32_t number = static_cast<std::int32_t>(level);
    if (number > s.level.load(std::memory_order_relaxed)) return;
    va_list args;
    va_start(args, pattern);
    try {
        const std::string text = vformat(pattern, args);
        LogHandler handler = nullptr;
        void* user_data = nullptr;
        {
            const std::lock_guard<std::mutex> lock(s.mutex);
            if (number <= s.level) handler = s.handler, user_data = s.user_data;
        }
        if (handler) handler(number, text.c_str(), user_data);  // outside the lock: a handler may call the library
    } catch (...) {
    }
    va_end(args);
}

}  // namespace dqa
