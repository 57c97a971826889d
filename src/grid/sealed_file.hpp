// SPDX-License-Identifier: MIT
// The library's own file format: magic, version, content, checksum. Little-endian, doubles as they are in memory, so
// that what is read back is the same to the last bit; written whole or not at all.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace dqa {

class SealedWriter {
public:
    SealedWriter(const char (&magic)[8], std::uint32_t version) : bytes_(magic, sizeof magic) { put(version); }

    template <class T>
    void put(const T& value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void integer(int value) { put(static_cast<std::int32_t>(value)); }
    void doubles(const double* p, std::size_t n) { bytes_.append(reinterpret_cast<const char*>(p), n * sizeof *p); }
    void text(const std::string& value) { bytes_ += value; }
    // Throws ERROR_IO; nothing was changed then.
    void save(const std::string& path);

private:
    std::string bytes_;
};

// Every failure is an ERROR_FILE (ERROR_IO if the file cannot be read) that names the file.
class SealedReader {
public:
    // Reads the file and checks beginning, version and checksum before anything in it is believed: a damaged count must
    // not drive an allocation. `what`: what a good file is, e.g. "a saved controller".
    SealedReader(const std::string& path, const char (&magic)[8], std::uint32_t version, const char* what);

    const std::string& path() const { return path_; }
    std::size_t left() const { return end_ - at_; }  // bytes of content not read yet
    // Fails unless n bytes are left; also to be asked before memory for them is.
    void need(std::size_t n) const;
    template <class T>
    T get() {
        T value;
        take(&value, sizeof value);
        return value;
    }
    void doubles(double* p, std::size_t n) { take(p, n * sizeof *p); }
    std::string text(std::size_t length);
    // A value that the rest of the library relies on: a good checksum does not say who wrote the file.
    void expect(bool good, const char* what, double value) const;
    int integer(const char* what, int least, int most);
    double positive(const char* what);

private:
    void take(void* out, std::size_t n);

    std::string path_, bytes_;
    std::size_t at_ = 0, end_ = 0;
};

}  // namespace dqa
