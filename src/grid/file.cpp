// SPDX-License-Identifier: MIT
#include "grid/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "grid/error.hpp"

namespace dqa {

void write_atomically(const std::string& path, const std::string& bytes) {
    const std::string temporary = path + ".tmp" + std::to_string(::getpid());
    const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0) fail(Status::ERROR_IO, "cannot write '%s': %s", temporary.c_str(), std::strerror(errno));
    std::size_t done = 0;
    int error = 0;
    while (done < bytes.size() && !error) {
        const ssize_t wrote = ::write(file, bytes.data() + done, bytes.size() - done);
        if (wrote < 0 && errno != EINTR) error = errno;
        if (wrote > 0) done += static_cast<std::size_t>(wrote);
    }
    if (!error && ::fsync(file) != 0 && errno != EINVAL) error = errno;
    if (::close(file) != 0 && !error) error = errno;
    if (!error && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    if (error) {
        ::unlink(temporary.c_str());
        fail(Status::ERROR_IO, "cannot write '%s': %s; nothing was changed", path.c_str(), std::strerror(error));
    }
}

std::string read_whole(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) fail(Status::ERROR_IO, "cannot open '%s': %s", path.c_str(), std::strerror(errno));
    std::string bytes;
    char buffer[65536];
    std::size_t got;
    while ((got = std::fread(buffer, 1, sizeof buffer, file)) > 0) bytes.append(buffer, got);
    const bool bad = std::ferror(file) != 0;
    const int error = errno;
    std::fclose(file);
    if (bad) fail(Status::ERROR_IO, "cannot read '%s': %s", path.c_str(), std::strerror(error));
    return bytes;
}

std::uint64_t fnv1a(const std::string& bytes, std::size_t length) {
    std::uint64_t h = 1469598103934665603ull;
    for (std::size_t i = 0; i < length; ++i) h = (h ^ static_cast<unsigned char>(bytes[i])) * 1099511628211ull;
    return h;
}

}  // namespace dqa
