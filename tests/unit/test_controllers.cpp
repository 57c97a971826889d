// SPDX-License-Identifier: MIT
// Perceptron, callback and file: sizes, initial weights, the formula against a plain one, derivatives, refusals.
#include <unistd.h>

#include <fstream>

#include "control/callback.hpp"
#include "control/controller_file.hpp"
#include "control/perceptron.hpp"
#include "derivative_checks.hpp"
#include "grid/file.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

PerceptronSettings settings_of(int n_signals, int dims, std::vector<int> hidden, bool encoding = true) {
    PerceptronSettings s;
    s.n_signals = n_signals, s.dims = dims, s.hidden = std::move(hidden), s.temporal_encoding = encoding;
    return s;
}

// The paper's table: 3 bases and 17 signals, 12 bases and one signal.
void test_numbers_of_parameters() {
    CHECK(3 + Perceptron(settings_of(17, 3, {64, 64})).parameters().size() == 7572);
    CHECK(12 + Perceptron(settings_of(1, 3, {64, 64})).parameters().size() == 6541);
    CHECK(Perceptron(settings_of(1, 3, {64, 64}, false)).parameters().size() == 16 * 64 + 65 * 64 + 65);
    CHECK(Perceptron(settings_of(2, 2, {})).parameters().size() == 31 * 2);
    CHECK(Perceptron({}).n_sensors() == 15 && Perceptron(settings_of(1, 2, {4})).n_sensors() == 10);
}

void test_initial_weights() {
    PerceptronSettings s = settings_of(3, 3, {16, 8});
    const Vector a = Perceptron(s).parameters();
    CHECK(a == Perceptron(s).parameters());
    // Layer by layer within its limit, and filling it; biases zero.
    std::size_t at = 0;
    for (const auto& [in, out] : {std::pair<std::size_t, std::size_t>{35, 16}, {16, 8}, {8, 3}}) {
        const double limit = std::sqrt(6.0 / static_cast<double>(in + out));
        double largest = 0.0, sum = 0.0;
        for (std::size_t k = 0; k < in * out; ++k) largest = std::max(largest, std::fabs(a[at + k])), sum += a[at + k];
        CHECK(largest < limit && largest > 0.8 * limit);
        NEAR(sum / static_cast<double>(in * out), 0.0, 0.35 * limit);
        for (std::size_t k = in * out; k < (in + 1) * out; ++k) CHECK(a[at + k] == 0.0);
        at += (in + 1) * out;
    }
    // The first number of seed 1, from the definition of splitmix64 (0x910a2dec89025cc1 after one round of state 1).
    NEAR(a[0], std::sqrt(6.0 / 51) * (2.0 * (static_cast<double>(0x910a2dec89025cc1ull >> 11) + 0.5) * 0x1p-53 - 1.0),
         1e-16);
    s.scale = 0.5;
    const Vector half = Perceptron(s).parameters();
    for (std::size_t k = 0; k < a.size(); ++k) NEAR(half[k], 0.5 * a[k], 1e-16);
    s.seed = 2;
    CHECK(Perceptron(s).parameters()[0] != half[0]);
}

// Written down once more, plainly.
void test_formula() {
    const Perceptron p(settings_of(2, 2, {3}));
    const Vector theta = p.parameters();
    Random random(5);
    const Vector sensors = random.vector(10);
    for (const long step : {0L, 1L, 24L, 25L, 1000000007L}) {
        Vector x = sensors;
        const double tau = static_cast<double>(step % 25) / 25.0;
        for (int k = 0; k < 10; ++k) x.push_back(std::sin(std::pow(2.0, k) * pi * tau));
        for (int k = 0; k < 10; ++k) x.push_back(std::cos(std::pow(2.0, k) * pi * tau));
        Vector h(3), y(2);
        for (std::size_t i = 0; i < 3; ++i) {
            double sum = theta[90 + i];
            for (std::size_t j = 0; j < 30; ++j) sum += theta[30 * i + j] * x[j];
            h[i] = std::tanh(sum);
        }
        for (std::size_t i = 0; i < 2; ++i) {
            double sum = theta[93 + 6 + i];
            for (std::size_t j = 0; j < 3; ++j) sum += theta[93 + 3 * i + j] * h[j];
            y[i] = std::tanh(sum);
        }
        double out[2];
        p.evaluate(step, sensors.data(), out);
        NEAR(out[0], y[0], 1e-13);
        NEAR(out[1], y[1], 1e-13);
    }
}

// By parameters and by sensors at once: x = (theta, sensors).
void check_controller(const char* name, Controller& c, const Vector& theta, double size) {
    Random random(9);
    const std::size_t n = theta.size(), m = static_cast<std::size_t>(c.n_sensors());
    Vector x = theta;
    for (std::size_t k = 0; k < m; ++k) x.push_back(random.uniform(-1.0, 1.0));
    derivative::Options options;
    options.step = options.taylor_step = size;
    const long step = 7;
    derivative::check_pullback(
        name,
        [&](const Vector& at) {
            c.assign_parameters(Vector(at.begin(), at.begin() + static_cast<long>(n)));
            Vector out(static_cast<std::size_t>(c.n_signals()));
            c.evaluate(step, at.data() + n, out.data());
            return out;
        },
        [&](const Vector& at, const Vector& bar) {
            c.assign_parameters(Vector(at.begin(), at.begin() + static_cast<long>(n)));
            Vector out(n + m, 0.0);
            c.pullback(step, at.data() + n, bar.data(), out.data(), out.data() + n);
            return out;
        },
        x, options);
}

void test_derivatives() {
    for (const auto& s : {settings_of(2, 3, {8, 6}), settings_of(3, 2, {}), settings_of(1, 3, {5, 4, 3}, false)}) {
        Perceptron p(s);
        Vector theta = p.parameters();
        Random random(3);
        for (double& t : theta) t += random.uniform(-0.1, 0.1);  // biases as well
        check_controller("perceptron", p, theta, 0.1);
    }
    Perceptron full({});
    check_controller("perceptron of the paper", full, full.parameters(), 0.3);
    Sinusoid sinusoid(2, 1.0 / 30);
    check_controller("sinusoid", sinusoid, {0.7, 9.0, 0.4, 0.3, 14.0, -0.8}, 0.1);
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[3] is 1.0000000000000002",
                 sinusoid.set_parameters({1, 9, 0, 1.0000000000000002, 9, 0}));
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[1] is 1e+308", sinusoid.set_parameters({1, 1e308, 0, 1, 9, 0}));
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[5] is -1e+300", sinusoid.set_parameters({1, 9, 0, 1, 9, -1e300}));
    Vector fastest(2);
    sinusoid.set_parameters({1, 3e7, 1e6, 1, -3e7, -1e6});
    sinusoid.evaluate(2147483647, nullptr, fastest.data());
    CHECK(std::fabs(fastest[0]) <= 1.0 && std::fabs(fastest[1]) <= 1.0);
}

// u_i = tanh(theta_0 + theta_1 s_i + theta_2 t); user_data: what to return and what to spoil.
struct Behaviour {
    std::int32_t result = 0;
    double spoil = 0.0;
    int calls = 0;
};
std::int32_t evaluate(std::int64_t step, double time, const double* sensors, std::int64_t, const double* theta,
                      std::int64_t, double* actuation, std::int64_t n_signals, void* user_data) {
    Behaviour* b = static_cast<Behaviour*>(user_data);
    ++b->calls;
    CHECK(std::fabs(time - 0.1 * static_cast<double>(step)) < 1e-12);
    for (std::int64_t k = 0; k < n_signals; ++k)
        actuation[k] = std::tanh(theta[0] + theta[1] * (sensors ? sensors[k] : 0.0) + theta[2] * time) + b->spoil;
    return b->result;
}
std::int32_t pullback(std::int64_t, double time, const double* sensors, std::int64_t, const double* theta, std::int64_t,
                      const double* actuation_bar, std::int64_t n_signals, double* theta_bar, double* sensors_bar,
                      void* user_data) {
    Behaviour* b = static_cast<Behaviour*>(user_data);
    for (std::int64_t k = 0; k < n_signals; ++k) {
        const double s = sensors ? sensors[k] : 0.0, y = std::tanh(theta[0] + theta[1] * s + theta[2] * time);
        const double bar = actuation_bar[k] * (1.0 - y * y);
        theta_bar[0] += bar, theta_bar[1] += s * bar, theta_bar[2] += time * bar;
        if (sensors) sensors_bar[k] += theta[1] * bar;
    }
    theta_bar[2] += b->spoil;
    return b->result;
}

void test_callback() {
    Behaviour b;
    CallbackSettings s;
    s.n_signals = 2, s.n_sensors = 15, s.time_step = 0.1, s.evaluate = evaluate, s.pullback = pullback;
    s.user_data = &b;
    CallbackController c(s, {0.2, -0.6, 0.4});
    CHECK(c.differentiable() && c.n_sensors() == 15 && c.parameters().size() == 3);
    check_controller("callback", c, {0.2, -0.6, 0.4}, 0.1);
    CHECK(b.calls > 10);
    const Vector sensors(15, 0.5), bar = {1.0, 1.0};
    Vector out(2), theta_bar(3, 1.0), sensors_bar(15, 1.0);
    b.result = 3;
    EXPECT_ERROR(CANCELLED, "evaluate callback returned 3 at step 4", c.evaluate(4, sensors.data(), out.data()));
    const auto back = [&] { c.pullback(4, sensors.data(), bar.data(), theta_bar.data(), sensors_bar.data()); };
    EXPECT_ERROR(CANCELLED, "pullback callback returned 3 at step 4", back());
    b.result = 0, b.spoil = 2.0;
    EXPECT_ERROR(ERROR_ARGUMENT, "actuation[0] = ", c.evaluate(4, sensors.data(), out.data()));
    b.spoil = std::nan("");
    EXPECT_ERROR(ERROR_ARGUMENT, "expected a number in [-1, 1]", c.evaluate(4, sensors.data(), out.data()));
    EXPECT_ERROR(ERROR_ARGUMENT, "theta_bar[2] = ", back());
    CHECK(theta_bar == Vector(3, 1.0) && sensors_bar == Vector(15, 1.0));  // all or nothing
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[1] is", c.set_parameters({0.0, std::nan(""), 0.0}));
    CHECK(c.equals(*c.clone()) && !c.equals(Sinusoid(2, 0.1)) && !Sinusoid(2, 0.1).equals(c));
    s.pullback = nullptr;
    CallbackController bare(s, {0.2, -0.6, 0.4});
    CHECK(!bare.differentiable() && !c.equals(bare));
    EXPECT_ERROR(ERROR_STATE, "no pullback callback",
                 bare.pullback(4, sensors.data(), bar.data(), theta_bar.data(), sensors_bar.data()));
    EXPECT_ERROR(ERROR_UNSUPPORTED, "the caller's own functions", save_controller(c, "callback.dqa"));
}

void test_files() {
    const std::string path = "controller.dqa";
    ::unlink(path.c_str());
    PerceptronSettings s = settings_of(3, 2, {7, 5}, false);
    s.seed = 0x123456789abcdefull, s.scale = 0.3, s.period_steps = 31;
    Perceptron p(s);
    Vector theta = p.parameters();
    theta[3] = 1.0 / 3.0, theta[5] = -0.0, theta[8] = 1e-300;
    p.set_parameters(theta);
    save_controller(p, path);
    const auto back = load_controller(path);
    CHECK(back->equals(p) && std::signbit(back->parameters()[5]));
    Sinusoid sinusoid(2, 0.05);
    sinusoid.set_parameters({0.5, 3.0, 0.25, 1.0, 7.0, -1.0});
    save_controller(sinusoid, path);  // over the old one
    CHECK(load_controller(path)->equals(sinusoid));

    const std::string good = read_whole(path);
    const auto write = [&](std::string bytes, bool sign) {
        if (sign) {
            const std::uint64_t sum = fnv1a(bytes, bytes.size() - 8);
            bytes.replace(bytes.size() - 8, 8, reinterpret_cast<const char*>(&sum), 8);
        }
        std::ofstream(path, std::ios::binary) << bytes;
    };
    for (std::size_t k = 0; k < good.size(); ++k) {  // any bit of any byte, and any length
        std::string bad = good;
        bad[k] = static_cast<char>(bad[k] ^ 0x10);
        write(bad, false);
        EXPECT_ERROR(ERROR_FILE, "controller.dqa", load_controller(path));
        write(good.substr(0, k), false);
        EXPECT_ERROR(ERROR_FILE, "controller.dqa", load_controller(path));
    }
    // A good checksum over senseless content: signals, time step, count, an amplitude of 1e9.
    const auto changed = [&](std::size_t at, const auto& value) {
        std::string bad = good;
        bad.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
        write(bad, true);
    };
    changed(8, std::int32_t{2});
    EXPECT_ERROR(ERROR_FILE, "version 2", load_controller(path));
    changed(12, std::int32_t{7});
    EXPECT_ERROR(ERROR_FILE, "kind of controller is 7", load_controller(path));
    changed(16, std::int32_t{-2});
    EXPECT_ERROR(ERROR_FILE, "number of signals is -2", load_controller(path));
    changed(16, std::int32_t{3});
    EXPECT_ERROR(ERROR_FILE, "expected 9 parameters", load_controller(path));
    changed(20, -1.0);
    EXPECT_ERROR(ERROR_FILE, "time_step is -1", load_controller(path));
    changed(28, std::uint64_t{1} << 60);
    EXPECT_ERROR(ERROR_FILE, "expected 6 parameters", load_controller(path));
    changed(36, 1e9);
    EXPECT_ERROR(ERROR_FILE, "theta[0] is 1e+09", load_controller(path));
    EXPECT_ERROR(ERROR_IO, "no_such_file", load_controller("no_such_file.dqa"));
    EXPECT_ERROR(ERROR_IO, "no_such_folder", save_controller(p, "no_such_folder/controller.dqa"));
    // A perceptron of 65536 x 65536 in a small file is refused before memory is asked for.
    save_controller(p, path);
    std::string bad = read_whole(path);
    const std::int32_t huge = 65536;
    for (const std::size_t at : {28u, 32u})
        bad.replace(at, sizeof huge, reinterpret_cast<const char*>(&huge), sizeof huge);
    write(bad, true);
    EXPECT_ERROR(ERROR_FILE, "is truncated", load_controller(path));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_numbers_of_parameters), TEST(test_initial_weights), TEST(test_formula),
        TEST(test_derivatives),           TEST(test_callback),        TEST(test_files),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
