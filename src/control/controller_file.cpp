// SPDX-License-Identifier: MIT
// Format: magic, version, kind, settings, parameters, checksum; little-endian, doubles as they are in memory.
#include "control/controller_file.hpp"

#include <cmath>
#include <cstring>

#include "control/perceptron.hpp"
#include "grid/error.hpp"
#include "grid/file.hpp"

namespace dqa {
namespace {

constexpr char kMagic[8] = {'D', 'Q', 'A', 'C', 'N', 'T', 'R', 'L'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kSinusoid = 0, kPerceptron = 1;

template <class T>
void put(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

struct Reader {
    const std::string& bytes;
    const std::string& path;
    std::size_t at, end;
    void need(std::size_t n) const {
        if (end - at < n)
            fail(Status::ERROR_FILE, "'%s' is truncated: %zu bytes expected at offset %zu, %zu there", path.c_str(), n,
                 at, end - at);
    }
    template <class T>
    T get() {
        need(sizeof(T));
        T value;
        std::memcpy(&value, bytes.data() + at, sizeof value);
        at += sizeof value;
        return value;
    }
    int integer(const char* what, int least, int most) {
        const int value = get<std::int32_t>();
        if (value < least || value > most)
            fail(Status::ERROR_FILE, "'%s': %s is %d, expected a number in [%d, %d]", path.c_str(), what, value, least,
                 most);
        return value;
    }
    double positive(const char* what) {
        const double value = get<double>();
        if (!(value > 0 && std::isfinite(value)))
            fail(Status::ERROR_FILE, "'%s': %s is %g, expected a finite number > 0", path.c_str(), what, value);
        return value;
    }
};

std::unique_ptr<Controller> read_sinusoid(Reader& r) {
    const int n_signals = r.integer("the number of signals", 1, 4096);
    return std::make_unique<Sinusoid>(n_signals, r.positive("time_step"));
}

std::unique_ptr<Controller> read_perceptron(Reader& r) {
    PerceptronSettings s;
    s.n_signals = r.integer("the number of signals", 1, 4096);
    s.dims = r.integer("dims", 2, 3);
    s.hidden.resize(static_cast<std::size_t>(r.integer("the number of hidden layers", 0, 64)));
    for (int& n : s.hidden) n = r.integer("a number of neurons", 1, 65536);
    s.temporal_encoding = r.integer("temporal_encoding", 0, 1) == 1;
    s.period_steps = r.integer("period_steps", 1, 1 << 30);
    s.seed = r.get<std::uint64_t>();
    s.scale = r.get<double>();
    if (!(s.scale >= 0 && std::isfinite(s.scale)))
        fail(Status::ERROR_FILE, "'%s': scale is %g, expected a number >= 0", r.path.c_str(), s.scale);
    r.need(sizeof(std::uint64_t) + Perceptron::count(s) * sizeof(double));  // before memory is asked for
    return std::make_unique<Perceptron>(s);
}

}  // namespace

void save_controller(const Controller& controller, const std::string& path) {
    std::string bytes(kMagic, sizeof kMagic);
    put(bytes, kVersion);
    if (const auto* sinusoid = dynamic_cast<const Sinusoid*>(&controller)) {
        put(bytes, kSinusoid);
        put(bytes, static_cast<std::int32_t>(sinusoid->n_signals()));
        put(bytes, sinusoid->time_step());
    } else if (const auto* perceptron = dynamic_cast<const Perceptron*>(&controller)) {
        const PerceptronSettings& s = perceptron->settings();
        put(bytes, kPerceptron);
        for (const int v : {s.n_signals, s.dims, static_cast<int>(s.hidden.size())})
            put(bytes, static_cast<std::int32_t>(v));
        for (const int n : s.hidden) put(bytes, static_cast<std::int32_t>(n));
        put(bytes, static_cast<std::int32_t>(s.temporal_encoding));
        put(bytes, static_cast<std::int32_t>(s.period_steps));
        put(bytes, s.seed);
        put(bytes, s.scale);
    } else {
        fail(Status::ERROR_UNSUPPORTED,
             "controller is made of the caller's own functions, which a file cannot hold: save its parameters instead");
    }
    const std::vector<double> theta = controller.parameters();
    put(bytes, static_cast<std::uint64_t>(theta.size()));
    bytes.append(reinterpret_cast<const char*>(theta.data()), theta.size() * sizeof(double));
    put(bytes, fnv1a(bytes, bytes.size()));
    write_atomically(path, bytes);
}

std::unique_ptr<Controller> load_controller(const std::string& path) {
    const std::string bytes = read_whole(path);
    if (bytes.size() < sizeof kMagic + 12 || std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0)
        fail(Status::ERROR_FILE, "'%s' is not a saved controller (%zu bytes, wrong beginning)", path.c_str(),
             bytes.size());
    Reader r{bytes, path, sizeof kMagic, bytes.size() - sizeof(std::uint64_t)};
    const std::uint32_t version = r.get<std::uint32_t>();
    if (version != kVersion)
        fail(Status::ERROR_FILE, "'%s' has format version %u, this library reads %u", path.c_str(), version, kVersion);
    // The checksum comes before anything is believed.
    std::uint64_t stored;
    std::memcpy(&stored, bytes.data() + r.end, sizeof stored);
    if (stored != fnv1a(bytes, r.end))
        fail(Status::ERROR_FILE, "'%s' is damaged or truncated: its checksum does not match", path.c_str());
    const int kind = r.integer("the kind of controller", kSinusoid, kPerceptron);
    std::unique_ptr<Controller> controller = kind == kSinusoid ? read_sinusoid(r) : read_perceptron(r);
    const std::uint64_t count = r.get<std::uint64_t>();
    std::vector<double> theta(controller->parameters().size());
    if (count != theta.size() || r.end - r.at != theta.size() * sizeof(double))
        fail(Status::ERROR_FILE, "'%s' holds %zu bytes of %llu parameters, expected %zu parameters", path.c_str(),
             r.end - r.at, static_cast<unsigned long long>(count), theta.size());
    std::memcpy(theta.data(), bytes.data() + r.at, theta.size() * sizeof(double));
    try {
        controller->set_parameters(theta);
    } catch (const Error& e) {
        fail(Status::ERROR_FILE, "'%s': %s", path.c_str(), e.what());
    }
    return controller;
}

}  // namespace dqa
