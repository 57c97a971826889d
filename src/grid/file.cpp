// SPDX-License-Identifier: MIT
#include "grid/file.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "grid/error.hpp"

namespace dqa {
namespace {

constexpr std::int64_t kMostBytes = std::int64_t{1} << 34;  // of a file of the library's own
constexpr std::size_t kPart = std::size_t{1} << 24;         // bytes read between two polls
constexpr int kTries = 100;                                 // names of temporary files
constexpr int kLinks = 40;                                  // symbolic links that lead to one another

[[noreturn]] void cannot_write(const std::string& path, const char* why) {
    fail(Status::ERROR_IO, "cannot write '%s': %s; nothing was changed", path.c_str(), why);
}

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

// Where a path leads: the links stay, and what they name is replaced, as editors do. It need not exist yet.
std::string behind_links(std::string path) {
    const std::string given = path;
    for (int k = 0; k < kLinks; ++k) {
        char target[PATH_MAX];
        const ssize_t length = ::readlink(path.c_str(), target, sizeof target);
        if (length < 0) return path;  // no link: a file, or nothing
        const std::string name(target, static_cast<std::size_t>(length));
        path = name[0] == '/' ? name : folder_of(path) + name;
    }
    cannot_write(given, std::strerror(ELOOP));
}

std::string random_suffix() {
    std::uint64_t bits = 0;
    if (::getrandom(&bits, sizeof bits, GRND_NONBLOCK) != static_cast<ssize_t>(sizeof bits))
        bits = reinterpret_cast<std::uintptr_t>(&bits) * 0x9E3779B97F4A7C15ull ^ static_cast<std::uint64_t>(::getpid());
    char text[24];
    std::snprintf(text, sizeof text, ".%016llx", static_cast<unsigned long long>(bits));
    return text;
}

// A new file beside `path`, under a name that nobody could know before.
int create_beside(const std::string& path, mode_t mode, std::string& name) {
    for (int k = 0; k < kTries; ++k) {
        name = path + random_suffix();
        const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        if (file >= 0 || errno != EEXIST) return file;
    }
    return -1;
}

// 0, or the number of an error.
int write_all(Descriptor& file, const std::string& bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t wrote = ::write(file.number(), bytes.data() + done, bytes.size() - done);
        if (wrote < 0 && errno != EINTR) return errno;
        if (wrote > 0) done += static_cast<std::size_t>(wrote);
    }
    if (::fsync(file.number()) != 0 && errno != EINVAL) return errno;
    return file.close() != 0 ? errno : 0;
}

}  // namespace

Descriptor::~Descriptor() {
    if (number_ >= 0) ::close(number_);
}

int Descriptor::close() {
    const int result = ::close(number_);
    number_ = -1;
    return result;
}

void write_atomically(const std::string& path, const std::string& bytes) {
    const std::string target = behind_links(path);
    struct stat old;
    const bool exists = ::stat(target.c_str(), &old) == 0;
    if (exists && S_ISDIR(old.st_mode)) cannot_write(path, std::strerror(EISDIR));
    if (exists && !S_ISREG(old.st_mode)) cannot_write(path, "it is no regular file (a device, pipe or socket)");
    std::string temporary;
    // A file that nobody else may read while it is written, where the old one is so.
    Descriptor file(create_beside(target, exists ? old.st_mode & 0777 : 0666, temporary));
    if (file.number() < 0) cannot_write(path, std::strerror(errno));
    int error = exists && ::fchmod(file.number(), old.st_mode & 07777) != 0 ? errno : 0;
    if (!error) error = write_all(file, bytes);
    if (!error && std::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
    if (!error) return;
    ::unlink(temporary.c_str());
    cannot_write(path, std::strerror(error));
}

Descriptor open_to_read(const std::string& path) {
    // Without blocking, so that a pipe is told apart before it is waited for.
    return Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

std::string read_whole(const std::string& path) {
    const Descriptor file = open_to_read(path);
    struct stat info;
    if (file.number() < 0 || ::fstat(file.number(), &info) != 0)
        fail(Status::ERROR_IO, "cannot open '%s': %s", path.c_str(), std::strerror(errno));
    if (!S_ISREG(info.st_mode))
        fail(Status::ERROR_IO, "cannot read '%s': %s", path.c_str(),
             S_ISDIR(info.st_mode) ? std::strerror(EISDIR) : "it is no regular file (a device, pipe or socket)");
    if (info.st_size > kMostBytes)
        fail(Status::ERROR_IO, "cannot read '%s': it has %lld bytes, expected at most %lld", path.c_str(),
             static_cast<long long>(info.st_size), static_cast<long long>(kMostBytes));
    std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
    const int error = read_into(file, bytes);  // one that has become shorter is told by its checksum
    if (error) fail(Status::ERROR_IO, "cannot read '%s': %s", path.c_str(), std::strerror(error));
    return bytes;
}

int read_into(const Descriptor& file, std::string& bytes, const std::function<void()>& poll) {
    std::size_t have = 0;
    while (have < bytes.size()) {
        if (poll) poll();
        const ssize_t got = ::read(file.number(), bytes.data() + have, std::min(bytes.size() - have, kPart));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return errno;
        if (got == 0) break;
        have += static_cast<std::size_t>(got);
    }
    bytes.resize(have);
    return 0;
}

std::uint64_t fnv1a(const std::string& bytes, std::size_t length) {
    std::uint64_t h = 1469598103934665603ull;
    for (std::size_t i = 0; i < length; ++i) h = (h ^ static_cast<unsigned char>(bytes[i])) * 1099511628211ull;
    return h;
}

}  // namespace dqa
