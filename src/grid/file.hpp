// SPDX-License-Identifier: MIT
// Whole files of the library's own formats: read at once, written so that a full disk or a kill leaves the old file
// whole, and a checksum of their bytes.
#pragma once

#include <cstdint>
#include <string>

namespace dqa {

// Writes to a temporary file beside the target, then renames: a reader sees the old file or the new one, whoever else
// writes. Links stay and what they name is replaced, with its mode; devices, pipes and folders are refused. Throws
// ERROR_IO; nothing was changed then.
void write_atomically(const std::string& path, const std::string& bytes);
// Of a regular file. Throws ERROR_IO.
std::string read_whole(const std::string& path);
// FNV-1a of the first `length` bytes.
std::uint64_t fnv1a(const std::string& bytes, std::size_t length);

}  // namespace dqa
