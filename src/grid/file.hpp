// SPDX-License-Identifier: MIT
// Whole files of the library's own formats: read at once, written so that a full disk or a kill leaves the old file
// whole, and a checksum of their bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace dqa {

// An open file, closed with the scope.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }  // negative: it could not be opened, errno tells why
    // Once: what a failed close leaves is undefined.
    int close();

private:
    int number_;
};

// Not waited for, whatever it is.
Descriptor open_to_read(const std::string& path);
// As many bytes as there are room for; fewer where the file ends before. 0, or the number of an error. `poll` may
// throw.
int read_into(const Descriptor& file, std::string& bytes, const std::function<void()>& poll = {});

// Writes to a temporary file beside the target, then renames: a reader sees the old file or the new one, whoever else
// writes. Links stay and what they name is replaced, with its mode; devices, pipes and folders are refused. Throws
// ERROR_IO; nothing was changed then.
void write_atomically(const std::string& path, const std::string& bytes);
// Of a regular file. Throws ERROR_IO.
std::string read_whole(const std::string& path);
// FNV-1a of the first `length` bytes.
std::uint64_t fnv1a(const std::string& bytes, std::size_t length);

}  // namespace dqa
