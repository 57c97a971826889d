// SPDX-License-Identifier: MIT
// Who uses a handle. Calls may run code of the caller's (progress, controllers, currents, log handlers), and that may
// call the library again, with any handle: a call that would pull the ground from under one that is under way is
// refused with DQA_ERROR_STATE, and a handle that is freed meanwhile lives until the last call with it ends.
#pragma once

#include <atomic>
#include <cstdint>

#include "grid/error.hpp"

namespace dqa::capi {

// Calls under way with one handle: any number that read it, or one that changes it. Without locks, so that nothing is
// left locked in a child of fork.
class Usage {
public:
    // False: the handle is in use, or was freed.
    bool begin_change() noexcept {
        std::uint32_t none = 0;
        return word_.compare_exchange_strong(none, kChange);
    }
    // Beside a change: for reads that find the object whole in the callbacks of a call that changes it.
    bool begin_read(bool beside_change) noexcept {
        std::uint32_t word = word_.load();
        do {
            if ((word & kFreed) != 0 || ((word & kChange) != 0 && !beside_change)) return false;
        } while (!word_.compare_exchange_weak(word, word + 1));
        return true;
    }
    // True: the handle was freed meanwhile, and nobody else uses it.
    bool end_change() noexcept { return word_.fetch_sub(kChange) == (kFreed | kChange); }
    bool end_read() noexcept { return word_.fetch_sub(1) == (kFreed | 1u); }
    // True: nobody uses it.
    bool free() noexcept { return (word_.fetch_or(kFreed) & ~kFreed) == 0; }
    bool changes() const noexcept { return (word_.load() & kChange) != 0; }

private:
    static constexpr std::uint32_t kFreed = 1u << 31, kChange = 1u << 30;
    std::atomic<std::uint32_t> word_{0};
};

struct Handle {
    mutable Usage use;
};

template <class T>
void free_handle(T* handle) noexcept {
    if (handle && handle->use.free()) delete handle;
}

[[noreturn]] inline void refuse_lease(const char* name) {
    fail(Status::ERROR_STATE,
         "%s: a call that uses it is under way, and this one comes from a callback of that, or from another thread; "
         "expected a call that does not change it",
         name);
}

// For the time of a call that changes the object behind a handle.
template <class T>
class Change {
public:
    Change(T* handle, const char* name) : handle_(handle) {
        if (!handle) fail(Status::ERROR_ARGUMENT, "%s is NULL, expected a valid pointer", name);
        if (!handle->use.begin_change()) refuse_lease(name);
    }
    Change(const Change&) = delete;
    Change& operator=(const Change&) = delete;
    ~Change() {
        if (handle_->use.end_change()) delete handle_;
    }

private:
    T* handle_;
};

enum class Beside { reads, changes };

// For the time of a call that reads it and runs code of the caller's. A null handle is one that the call does without.
template <class T>
class Read {
public:
    Read(const T* handle, const char* name, Beside beside = Beside::reads) : handle_(handle) {
        if (handle && !handle->use.begin_read(beside == Beside::changes)) refuse_lease(name);
    }
    Read(const Read&) = delete;
    Read& operator=(const Read&) = delete;
    ~Read() {
        if (handle_ && handle_->use.end_read()) delete handle_;
    }

private:
    const T* handle_;
};

}  // namespace dqa::capi
