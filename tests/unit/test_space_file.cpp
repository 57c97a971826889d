// SPDX-License-Identifier: MIT
// A shape space on disk: the same bits when read back, an error for everything that is not such a file, and an old file
// left whole when a new one cannot be written.
#include <dirent.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "shape/shape_space.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;

const Cells cells{20, 8, 10};

// A folder that goes away with everything in it.
class Folder {
public:
    Folder() {
        const char* base = std::getenv("TMPDIR");
        path_ = std::string(base && *base ? base : "/tmp") + "/dqa_space_XXXXXX";
        if (!mkdtemp(path_.data())) throw std::runtime_error("mkdtemp failed");
    }
    ~Folder() {
        ::chmod(path_.c_str(), 0700);
        for (const std::string& name : names()) ::unlink((path_ + "/" + name).c_str());
        ::rmdir(path_.c_str());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }
    std::vector<std::string> names() const {
        std::vector<std::string> out;
        if (DIR* d = ::opendir(path_.c_str())) {
            while (const dirent* e = ::readdir(d))
                if (e->d_name[0] != '.') out.emplace_back(e->d_name);
            ::closedir(d);
        }
        return out;
    }

private:
    std::string path_;
};

std::shared_ptr<ShapeSpace> space(double sigma = 0.8, int refinement = 1) {
    ShapeSettings s;
    s.cells = cells, s.sigma = sigma, s.cell_size = 0.05, s.body_length = 0.9, s.tolerance = 1e-8, s.subsamples = 5;
    s.interpolation = Interpolation::bures, s.automatic_fins = true, s.refinement = refinement;
    s.margin = 1, s.up = 2, s.peak = Peak::paper, s.max_iterations = 777;
    auto out = std::make_shared<ShapeSpace>(s);
    out->add_fractions("one, with \"quotes\" and \n", soft_ellipsoid(cells, {10, 4, 5}, {7.6, 2.1, 2.7}).data());
    out->add_fractions("", soft_ellipsoid(cells, {10.3, 4.2, 4.6}, {5.4, 2.5, 3.4}).data());
    Actuator a;
    a.mean = {-0.12, 0, 0.02}, a.variance = {0.01, 0.004, 0.007}, a.euler = {0.1, 0.2, -0.1};
    out->add_actuator(1, a);
    a.category = 6, a.kind = ActuatorKind::fins, a.layers = 3;
    a.variance = {0.01, 0.007, 0.004};
    out->add_actuator(1, a);
    out->build(nullptr);
    return out;
}

std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void write(const std::string& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

// With the checksum that belongs to what comes before it (FNV-1a, 64 bits).
std::string sealed(std::string bytes) {
    std::uint64_t h = 1469598103934665603ull;
    for (std::size_t i = 0; i + 8 < bytes.size(); ++i)
        h = (h ^ static_cast<unsigned char>(bytes[i])) * 1099511628211ull;
    std::memcpy(bytes.data() + bytes.size() - 8, &h, 8);
    return bytes;
}

void check_round_trip(int refinement) {
    const Folder folder;
    const auto before = space(0.8, refinement);
    before->save(folder / "a");
    const auto after = ShapeSpace::load(folder / "a");
    CHECK(folder.names().size() == 1);
    const ShapeSettings &s = before->settings(), &t = after->settings();
    CHECK(after->built() && s.cells == t.cells && s.margin == t.margin && s.up == t.up && s.subsamples == t.subsamples);
    CHECK(s.peak == t.peak && s.max_iterations == t.max_iterations && s.body_length == t.body_length);
    CHECK(s.cell_size == t.cell_size && s.sigma == t.sigma && s.tolerance == t.tolerance);
    CHECK(before->box().dx == after->box().dx && before->categories() == after->categories());
    CHECK(s.interpolation == t.interpolation && s.automatic_fins == t.automatic_fins);
    CHECK(s.refinement == t.refinement && s.refinement == refinement);
    CHECK(before->slots() == after->slots() && before->fibres_turn() == after->fibres_turn());
    CHECK(before->axis_y() == after->axis_y() && before->axis_z() == after->axis_z());
    CHECK(after->bases().size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        const BaseShape &b = before->bases()[i], &c = after->bases()[i];
        CHECK(b.name == c.name && b.fractions == c.fractions && b.fine == c.fine && b.density == c.density);
        CHECK(b.density.size() == b.fractions.size() * static_cast<std::size_t>(refinement * refinement * refinement));
        CHECK(b.length_in_cells == c.length_in_cells && b.actuators.size() == (i == 0 ? 1u : 3u));
        CHECK(b.actuators.size() == c.actuators.size());
        for (std::size_t k = 0; k < b.actuators.size(); ++k) {
            const Actuator &p = b.actuators[k], &q = c.actuators[k];
            CHECK(p.mean == q.mean && p.variance == q.variance && p.euler == q.euler && p.category == q.category);
            CHECK(p.kind == q.kind && p.half == q.half && p.layers == q.layers);
        }
    }
    CHECK(before->evaluate({0.3, 0.7}, 0, 0, nullptr).p_hat == after->evaluate({0.3, 0.7}, 0, 0, nullptr).p_hat);
    after->save(folder / "b");
    CHECK(content(folder / "a") == content(folder / "b"));
    EXPECT_ERROR(ERROR_STATE, "already built", after->build(nullptr));
}

void test_round_trip() {
    for (const int refinement : {1, 2, 3}) check_round_trip(refinement);
}

void test_damaged_files() {
    const Folder folder;
    space()->save(folder / "good");
    const std::string good = content(folder / "good"), path = folder / "bad";
    CHECK(sealed(good) == good);
    const auto refused = [&](const std::string& bytes, const char* part) {
        write(path, bytes);
        EXPECT_ERROR(ERROR_FILE, part, ShapeSpace::load(path));
    };
    for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{8}, std::size_t{19}})
        refused(good.substr(0, length), "not a saved shape space");
    for (std::size_t length = 20; length < good.size(); length += 997) refused(good.substr(0, length), "");
    refused(good.substr(0, good.size() - 1), "damaged or truncated");
    refused(good + '\0', "damaged or truncated");
    for (std::size_t at = 0; at < good.size(); at += 501) {
        std::string bytes = good;
        bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
        refused(bytes, "");
    }
    refused("solid not a shape space, but something else of some length", "not a saved shape space");
    std::string newer = good;
    newer[8] = 99;
    refused(sealed(newer), "format version 99");
    newer[8] = 2;
    refused(sealed(newer), "format version 2, this library reads 4");
    EXPECT_ERROR(ERROR_IO, "cannot open", ShapeSpace::load(folder / "none"));
    EXPECT_ERROR(ERROR_IO, "cannot read", ShapeSpace::load(folder.path()));
}

// A good checksum over bad content: a file made by something else. Nothing of it may be believed.
void test_forged_files() {
    const Folder folder;
    space()->save(folder / "good");
    const std::string good = content(folder / "good"), path = folder / "bad";
    constexpr std::size_t dims = 12, ints = 16, doubles = 64,
                          bases = 104;  // offsets: dims; cells, margin..; body length..; count of bases
    const auto refused = [&](std::string bytes, const char* what) {
        write(path, sealed(std::move(bytes)));
        try {
            ShapeSpace::load(path);
        } catch (const Error& e) {
            if (e.status() == Status::ERROR_FILE) return;
            throw std::runtime_error(format("%s: status %d, '%s'", what, int(e.status()), e.what()));
        } catch (const std::exception& e) {
            throw std::runtime_error(format("%s: '%s'", what, e.what()));
        }
        throw std::runtime_error(format("%s: no error", what));
    };
    const auto with_int = [&](std::size_t at, std::uint32_t value) {
        std::string bytes = good;
        std::memcpy(bytes.data() + at, &value, 4);
        return bytes;
    };
    const auto with_double = [&](std::size_t at, double value) {
        std::string bytes = good;
        std::memcpy(bytes.data() + at, &value, 8);
        return bytes;
    };
    double sigma;
    std::memcpy(&sigma, good.data() + doubles + 16, 8);
    CHECK(sigma == 0.8);  // the offsets are right
    refused(with_int(dims, 4), "four dimensions");
    refused(with_int(dims, 2), "a plane of several layers");
    refused(with_int(ints, 0), "no cells");
    refused(with_int(ints, 513), "too many cells");
    refused(with_int(ints, 19), "fewer cells");
    refused(with_int(ints + 28, 7), "unknown peak");
    refused(with_int(ints + 32, 0), "no iterations");
    refused(with_int(ints + 36, 2), "unknown interpolation");
    refused(with_int(ints + 40, 2), "neither with nor without fins");
    refused(with_int(ints + 44, 0), "no finer cells");
    refused(with_int(ints + 44, 2), "finer cells without their fractions");
    refused(with_int(ints + 44, 5), "too fine cells");
    for (const double x : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
        refused(with_double(doubles, x), "body length");
        refused(with_double(doubles + 16, x), "sigma");
        refused(with_double(doubles + 24, x), "tolerance");
        refused(with_double(doubles + 32, x), "edge of a cell");
        if (x != 0) refused(with_double(doubles + 8, x), "cell size");
    }
    refused(with_int(bases, 0), "no bases");
    refused(with_int(bases, 1), "more content than bases");
    refused(with_int(bases, 3), "more bases than content");
    refused(with_int(bases, 0xffffffffu), "very many bases");
    refused(with_int(bases + 4, 0xffffffffu), "an endless name");
    const std::size_t fractions = bases + 8 + space()->bases()[0].name.size() + 8;
    refused(with_double(fractions - 8, std::nan("")), "length");
    for (const double x : {-0.1, 1.1, std::nan("")}) refused(with_double(fractions + 800, x), "a fraction");
    const std::size_t n = 8 * 20 * 8 * 10;
    std::string empty = good;
    std::fill_n(empty.begin() + static_cast<long>(fractions), n, '\0');
    refused(empty, "an empty base");
    refused(with_int(fractions + n, 0xffffffffu), "very many actuators");
    const std::size_t actuator = fractions + n + 4;
    refused(with_int(actuator, 16), "unknown category");
    refused(with_int(actuator + 4, 2), "unknown kind");
    refused(with_int(actuator + 4, 1), "fins without a side");
    refused(with_int(actuator + 8, 1), "a caudal actuator with a side");
    refused(with_int(actuator + 12, 0), "no layers");
    refused(with_int(actuator + 12, 5), "too many layers");
    refused(with_double(actuator + 16, HUGE_VAL), "mean");
    refused(with_double(actuator + 16 + 24, -1.0), "variance");
    refused(with_double(actuator + 16 + 48, std::nan("")), "angle");
    refused(with_int(actuator, 6), "a number that is fins in another base");
    write(path, sealed(good));
    ShapeSpace::load(path);
}

void test_unwritable() {
    const Folder folder;
    const auto s = space();
    EXPECT_ERROR(ERROR_IO, "cannot write", s->save(folder / "none/file"));
    write(folder / "file", "old");
    EXPECT_ERROR(ERROR_IO, "cannot write", s->save(folder / "file/below"));
    EXPECT_ERROR(ERROR_IO, "nothing was changed", s->save(folder.path()));  // a folder is in the way of the name
    ::chmod(folder.path().c_str(), 0500);
    if (::geteuid() != 0) EXPECT_ERROR(ERROR_IO, "cannot write", s->save(folder / "file"));
    ::chmod(folder.path().c_str(), 0700);
    CHECK(folder.names().size() == 1 && content(folder / "file") == "old");
    const std::string beside = folder.path() + ".tmp" + std::to_string(::getpid());
    CHECK(::access(beside.c_str(), F_OK) != 0);
    ShapeSpace open{ShapeSettings{}};
    EXPECT_ERROR(ERROR_STATE, "not built", open.save(folder / "file"));
    CHECK(content(folder / "file") == "old");
}

// A disk that fills up, as a limit on the size of files in a child process.
void test_full_disk() {
    const Folder folder;
    const std::string path = folder / "space";
    space()->save(path);
    const std::string before = content(path);
    const auto other = space(0.9);
    const pid_t child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{1000, 1000};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        int code = 1;
        try {
            other->save(path);
        } catch (const Error& e) {
            code = e.status() == Status::ERROR_IO && std::strstr(e.what(), "nothing was changed") ? 0 : 2;
        } catch (...) {
            code = 3;
        }
        ::_exit(code);
    }
    CHECK(child > 0);
    int status = -1;
    CHECK(::waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    CHECK(folder.names().size() == 1 && content(path) == before);
    other->save(path);  // with room again
    CHECK(content(path) != before && ShapeSpace::load(path)->settings().sigma == 0.9);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_round_trip), TEST(test_damaged_files), TEST(test_forged_files),
        TEST(test_unwritable), TEST(test_full_disk),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
