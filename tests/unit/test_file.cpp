// SPDX-License-Identifier: MIT
// Files of the library's own: what saving leaves alone (links, modes, devices, the old file when it fails), two writers
// of one path, and what reading refuses to wait for.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "grid/file.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
namespace fs = std::filesystem;

class Folder {
public:
    Folder() {
        char path[] = "/tmp/dqa_file_XXXXXX";
        if (!mkdtemp(path)) throw std::runtime_error("mkdtemp failed");
        path_ = path;
    }
    ~Folder() { fs::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::string operator/(const char* name) const { return path_ + "/" + name; }
    std::size_t entries() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

private:
    std::string path_;
};

mode_t mode_of(const std::string& path) {
    struct stat s;
    CHECK(::stat(path.c_str(), &s) == 0);
    return s.st_mode & 07777;
}

void test_modes() {
    const Folder folder;
    const std::string path = folder / "file";
    const mode_t mask = ::umask(022);
    write_atomically(path, "one");
    CHECK(mode_of(path) == 0644);
    for (const mode_t mode : {0600, 0640, 0755, 0664}) {
        CHECK(::chmod(path.c_str(), mode) == 0);
        write_atomically(path, "two");
        CHECK(mode_of(path) == mode && read_whole(path) == "two");
    }
    ::umask(077);
    write_atomically(folder / "private", "three");
    CHECK(mode_of(folder / "private") == 0600);
    ::umask(mask);
    CHECK(folder.entries() == 2);
}

void test_links() {
    const Folder folder;
    CHECK(::mkdir((folder / "deep").c_str(), 0755) == 0);
    CHECK(::symlink("deep/target", (folder / "link").c_str()) == 0);
    CHECK(::symlink("link", (folder / "twice").c_str()) == 0);
    write_atomically(folder / "link", "made through a dangling link");
    CHECK(read_whole(folder / "deep/target") == "made through a dangling link");
    write_atomically(folder / "twice", "changed");
    CHECK(read_whole(folder / "deep/target") == "changed");
    CHECK(fs::is_symlink(folder / "link") && fs::is_symlink(folder / "twice"));
    CHECK(::symlink((folder / "deep/target").c_str(), (folder / "whole").c_str()) == 0);
    write_atomically(folder / "whole", "by its whole path");
    CHECK(read_whole(folder / "link") == "by its whole path");
    CHECK(::symlink("b", (folder / "a").c_str()) == 0 && ::symlink("a", (folder / "b").c_str()) == 0);
    EXPECT_ERROR(ERROR_IO, "symbolic links", write_atomically(folder / "a", "x"));
}

void test_what_is_no_file() {
    const Folder folder;
    CHECK(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
    EXPECT_ERROR(ERROR_IO, "no regular file", write_atomically(folder / "pipe", "x"));
    EXPECT_ERROR(ERROR_IO, "no regular file", read_whole(folder / "pipe"));
    EXPECT_ERROR(ERROR_IO, "no regular file", write_atomically("/dev/null", "x"));
    EXPECT_ERROR(ERROR_IO, "no regular file", read_whole("/dev/zero"));
    EXPECT_ERROR(ERROR_IO, "directory", write_atomically(folder / ".", "x"));
    EXPECT_ERROR(ERROR_IO, "directory", read_whole(folder / "."));
    EXPECT_ERROR(ERROR_IO, "No such file", write_atomically(folder / "none/file", "x"));
    EXPECT_ERROR(ERROR_IO, "No such file", read_whole(folder / "none"));
    CHECK(fs::is_fifo(folder / "pipe") && folder.entries() == 1);
}

// A full disk: the old file is whole, and nothing lies beside it.
void test_full_disk() {
    const Folder folder;
    const std::string path = folder / "file";
    write_atomically(path, "old");
    struct rlimit before;
    CHECK(::getrlimit(RLIMIT_FSIZE, &before) == 0);
    struct rlimit small = before;
    small.rlim_cur = 1000;
    ::signal(SIGXFSZ, SIG_IGN);
    CHECK(::setrlimit(RLIMIT_FSIZE, &small) == 0);
    std::string message;
    try {
        write_atomically(path, std::string(100000, 'x'));
    } catch (const Error& e) {
        message = e.what();
    }
    CHECK(::setrlimit(RLIMIT_FSIZE, &before) == 0);
    CHECK(message.find(path) != std::string::npos && message.find("nothing was changed") != std::string::npos);
    CHECK(read_whole(path) == "old" && folder.entries() == 1);
}

// Two threads save to one path while a third reads: always one of the two, whole.
void test_two_writers() {
    const Folder folder;
    const std::string path = folder / "file", one(3000, '1'), other(70000, '2');
    write_atomically(path, one);
    std::atomic<int> bad{0};
    std::atomic<bool> stop{false};
    const auto writer = [&](const std::string& bytes) {
        for (int k = 0; k < 100; ++k) try {
                write_atomically(path, bytes);
            } catch (const Error&) {
                ++bad;
            }
    };
    std::thread reader([&] {
        while (!stop) {
            const std::string got = read_whole(path);
            bad += got != one && got != other;
        }
    });
    std::thread a(writer, one), b(writer, other);
    a.join(), b.join();
    stop = true;
    reader.join();
    CHECK(bad == 0 && folder.entries() == 1);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_modes), TEST(test_links), TEST(test_what_is_no_file), TEST(test_full_disk), TEST(test_two_writers),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
