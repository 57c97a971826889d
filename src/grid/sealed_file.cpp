// SPDX-License-Identifier: MIT
#include "grid/sealed_file.hpp"

#include <cmath>

#include "grid/error.hpp"
#include "grid/file.hpp"

namespace dqa {

void SealedWriter::save(const std::string& path) {
    put(fnv1a(bytes_, bytes_.size()));
    write_atomically(path, bytes_);
}

SealedReader::SealedReader(const std::string& path, const char (&magic)[8], std::uint32_t version, const char* what)
    : path_(path), bytes_(read_whole(path)) {
    std::uint64_t stored;
    if (bytes_.size() < sizeof magic + sizeof version + sizeof stored ||
        std::memcmp(bytes_.data(), magic, sizeof magic) != 0)
        fail(Status::ERROR_FILE, "'%s' is not %s (%zu bytes, wrong beginning)", path_.c_str(), what, bytes_.size());
    at_ = sizeof magic;
    end_ = bytes_.size() - sizeof stored;
    const auto found = get<std::uint32_t>();
    if (found != version)
        fail(Status::ERROR_FILE, "'%s' has format version %u, this library reads %u", path_.c_str(), found, version);
    std::memcpy(&stored, bytes_.data() + end_, sizeof stored);
    if (stored != fnv1a(bytes_, end_))
        fail(Status::ERROR_FILE, "'%s' is damaged or truncated: its checksum does not match", path_.c_str());
}

void SealedReader::need(std::size_t n) const {
    if (left() < n)
        fail(Status::ERROR_FILE, "'%s' is truncated: %zu bytes expected at offset %zu, %zu there", path_.c_str(), n,
             at_, left());
}

void SealedReader::take(void* out, std::size_t n) {
    need(n);
    bytes_.copy(static_cast<char*>(out), n, at_);  // not memcpy: nowhere is a good place for no bytes
    at_ += n;
}

std::string SealedReader::text(std::size_t length) {
    need(length);
    at_ += length;
    return bytes_.substr(at_ - length, length);
}

void SealedReader::expect(bool good, const char* what, double value) const {
    if (!good) fail(Status::ERROR_FILE, "'%s': %s is %g, out of range", path_.c_str(), what, value);
}

int SealedReader::integer(const char* what, int least, int most) {
    const int value = get<std::int32_t>();
    if (value < least || value > most)
        fail(Status::ERROR_FILE, "'%s': %s is %d, expected a number in [%d, %d]", path_.c_str(), what, value, least,
             most);
    return value;
}

double SealedReader::positive(const char* what) {
    const double value = get<double>();
    if (!(value > 0 && std::isfinite(value)))
        fail(Status::ERROR_FILE, "'%s': %s is %g, expected a finite number > 0", path_.c_str(), what, value);
    return value;
}

}  // namespace dqa
