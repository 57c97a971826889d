// SPDX-License-Identifier: MIT
// A fuzzer's bytes taken as choices, and files that have no name.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

namespace fuzz {

// Zeros follow the last byte.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
    bool over() const { return at_ == end_; }
    int byte() { return over() ? 0 : *at_++; }
    int below(int n) { return byte() % n; }
    std::size_t length() const { return static_cast<std::size_t>(end_ - at_); }
    std::string rest() {
        const std::string text(reinterpret_cast<const char*>(at_), length());
        at_ = end_;
        return text;
    }
    // Numbers that methods do not like, and some that they do.
    double number() {
        static constexpr double kNumbers[] = {0.0,
                                              -0.0,
                                              1.0,
                                              -1.0,
                                              0.5,
                                              0.1,
                                              1.0 + std::numeric_limits<double>::epsilon(),
                                              2.0,
                                              1e-3,
                                              1e-9,
                                              1e3,
                                              1e9,
                                              1e30,
                                              -1e30,
                                              1e154,
                                              std::numeric_limits<double>::max(),
                                              std::numeric_limits<double>::lowest(),
                                              std::numeric_limits<double>::min(),
                                              std::numeric_limits<double>::denorm_min(),
                                              std::numeric_limits<double>::infinity(),
                                              -std::numeric_limits<double>::infinity(),
                                              std::numeric_limits<double>::quiet_NaN()};
        constexpr int n = static_cast<int>(sizeof kNumbers / sizeof *kNumbers);
        const int choice = byte();
        return choice < n ? kNumbers[choice] : (choice - 128) / 32.0;
    }
    std::int64_t integer() {
        static constexpr std::int64_t kIntegers[] = {-1,
                                                     256,
                                                     65536,
                                                     std::numeric_limits<std::int32_t>::max(),
                                                     std::numeric_limits<std::int32_t>::min(),
                                                     std::numeric_limits<std::int64_t>::max(),
                                                     std::numeric_limits<std::int64_t>::min(),
                                                     std::int64_t(1) << 40};
        const int choice = byte();
        return choice < 8 ? kIntegers[choice] : choice - 8;
    }

private:
    const std::uint8_t *at_, *end_;
};

// A regular file in memory, with a path as long as this lives.
class MemoryFile {
public:
    explicit MemoryFile(const std::string& content) : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
        if (descriptor_ < 0 ||
            write(descriptor_, content.data(), content.size()) != static_cast<ssize_t>(content.size()))
            throw std::runtime_error("no file in memory");
        path_ = "/proc/self/fd/" + std::to_string(descriptor_);
    }
    ~MemoryFile() { close(descriptor_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    const char* path() const { return path_.c_str(); }

private:
    int descriptor_;
    std::string path_;
};

}  // namespace fuzz
