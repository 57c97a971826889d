// SPDX-License-Identifier: MIT
// Messages about what the library does, for the process's one handler; silent until capi/ installs it. Their texts are
// for people: no program should depend on them.
#pragma once

#include <cstdint>

namespace dqa {

// The numbers are the ABI's DQA_LOG_*.
enum class LogLevel : std::int32_t {
    error = 1,    // a call is about to fail for a reason that its message does not hold
    warning = 2,  // the result is right, but not the way or the input that one would expect
    info = 3,     // about one message a call
    debug = 4,    // about one message a step or solve
};

using LogHandler = void (*)(std::int32_t level, const char* message, void* user_data);

// handler null: silence. Safe from any thread; a message under way in another thread still goes to the old handler.
void set_log_handler(LogHandler handler, std::int32_t level, void* user_data);
// printf-style. Costs one atomic load when nobody listens at this level. Never throws: a message that cannot be made is
// dropped.
void log_message(LogLevel level, const char* pattern, ...) noexcept __attribute__((format(printf, 2, 3)));

}  // namespace dqa
