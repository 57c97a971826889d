// SPDX-License-Identifier: MIT
// Content of the sealed file: kind, settings, parameters.
#include "control/controller_file.hpp"

#include <cmath>

#include "control/perceptron.hpp"
#include "grid/error.hpp"
#include "grid/sealed_file.hpp"

namespace dqa {
namespace {

constexpr char kMagic[8] = {'D', 'Q', 'A', 'C', 'N', 'T', 'R', 'L'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kSinusoid = 0, kPerceptron = 1;

std::unique_ptr<Controller> read_sinusoid(SealedReader& r) {
    const int n_signals = r.integer("the number of signals", 1, 4096);
    return std::make_unique<Sinusoid>(n_signals, r.positive("time_step"));
}

std::unique_ptr<Controller> read_perceptron(SealedReader& r) {
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
        fail(Status::ERROR_FILE, "'%s': scale is %g, expected a number >= 0", r.path().c_str(), s.scale);
    r.need(sizeof(std::uint64_t) + Perceptron::count(s) * sizeof(double));  // before memory is asked for
    return std::make_unique<Perceptron>(s);
}

}  // namespace

void save_controller(const Controller& controller, const std::string& path) {
    SealedWriter w(kMagic, kVersion);
    if (const auto* sinusoid = dynamic_cast<const Sinusoid*>(&controller)) {
        w.put(kSinusoid);
        w.integer(sinusoid->n_signals());
        w.put(sinusoid->time_step());
    } else if (const auto* perceptron = dynamic_cast<const Perceptron*>(&controller)) {
        const PerceptronSettings& s = perceptron->settings();
        w.put(kPerceptron);
        for (const int v : {s.n_signals, s.dims, static_cast<int>(s.hidden.size())}) w.integer(v);
        for (const int n : s.hidden) w.integer(n);
        w.integer(s.temporal_encoding);
        w.integer(s.period_steps);
        w.put(s.seed);
        w.put(s.scale);
    } else {
        fail(Status::ERROR_UNSUPPORTED,
             "controller is made of the caller's own functions, which a file cannot hold: save its parameters instead");
    }
    const std::vector<double> theta = controller.parameters();
    w.put(static_cast<std::uint64_t>(theta.size()));
    w.doubles(theta.data(), theta.size());
    w.save(path);
}

std::unique_ptr<Controller> load_controller(const std::string& path) {
    SealedReader r(path, kMagic, kVersion, "a saved controller");
    const int kind = r.integer("the kind of controller", kSinusoid, kPerceptron);
    std::unique_ptr<Controller> controller = kind == kSinusoid ? read_sinusoid(r) : read_perceptron(r);
    const std::uint64_t count = r.get<std::uint64_t>();
    std::vector<double> theta(controller->parameters().size());
    if (count != theta.size() || r.left() != theta.size() * sizeof(double))
        fail(Status::ERROR_FILE, "'%s' holds %zu bytes of %llu parameters, expected %zu parameters", path.c_str(),
             r.left(), static_cast<unsigned long long>(count), theta.size());
    r.doubles(theta.data(), theta.size());
    try {
        controller->set_parameters(theta);
    } catch (const Error& e) {
        fail(Status::ERROR_FILE, "'%s': %s", path.c_str(), e.what());
    }
    return controller;
}

}  // namespace dqa
