// SPDX-License-Identifier: MIT
// Is a pullback the transpose of its map's derivative? Three answers for f: R^n -> R^m at a point x, with deterministic
// random covectors w and directions d:
//   Taylor       |<w, f(x + e d)> - <w, f(x)> - e <pullback(w), d>| falls like e^2 (slope 2 +- 0.1);
//   differences  <pullback(w), d> is the five-point difference of <w, f> to 1e-6, and is not zero;
//   dot product  <pullback(w), d> = <w, J d>, J d by differences of every component.
// The step of a difference is the one at which two neighbours of the ladder agree best: the pullback has no say in it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace derivative {

using Vector = std::vector<double>;
using Map = std::function<Vector(const Vector& x)>;
using Pullback = std::function<Vector(const Vector& x, const Vector& bar)>;

// splitmix64: the same numbers everywhere.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double uniform(double lo, double hi) {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return lo + (hi - lo) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
    }
    Vector vector(std::size_t n, double lo = -1.0, double hi = 1.0) {
        Vector v(n);
        for (double& x : v) x = uniform(lo, hi);
        return v;
    }

private:
    std::uint64_t state_;
};

struct Options {
    double step = 1e-2;         // longest step of differences, in units of d
    double taylor_step = 1e-2;  // and of the Taylor ladder
    double noise = 1e-15;       // relative error of the entries of f
    double relative = 1e-6;     // agreement of differences
    bool one_sided = false;     // x + e d exists for e >= 0 only
    bool affine = false;        // f is affine along d: the remainder is zero instead of quadratic
    std::uint64_t seed = 1;
    std::vector<Vector> directions{};  // empty: random ones with a part along the gradient
};

inline double dot(const Vector& a, const Vector& b) {
    if (a.size() != b.size()) throw std::runtime_error("dot: sizes differ");
    double s = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) s += a[k] * b[k];
    return s;
}

inline double norm(const Vector& a) {
    return std::sqrt(dot(a, a));
}

inline Vector along(const Vector& x, double e, const Vector& d) {
    Vector y = x;
    for (std::size_t k = 0; k < x.size(); ++k) y[k] += e * d[k];
    return y;
}

// Fourth-order difference quotient of f along d.
inline Vector quotient(const Map& f, const Vector& x, const Vector& d, double h, bool one_sided) {
    static constexpr std::array<std::array<double, 2>, 4> central{
        {{-2, 1. / 12}, {-1, -8. / 12}, {1, 8. / 12}, {2, -1. / 12}}};
    static constexpr std::array<std::array<double, 2>, 5> forward{
        {{0, -25. / 12}, {1, 4}, {2, -3}, {3, 4. / 3}, {4, -1. / 4}}};
    Vector out;
    const auto add = [&](const std::array<double, 2>& term) {
        const Vector y = f(along(x, term[0] * h, d));
        out.resize(y.size(), 0.0);
        for (std::size_t k = 0; k < y.size(); ++k) out[k] += term[1] / h * y[k];
    };
    if (one_sided) {
        for (const auto& term : forward) add(term);
    } else {
        for (const auto& term : central) add(term);
    }
    return out;
}

// What f does along d: evaluated once, for any number of covectors.
struct Samples {
    Vector direction, f0;
    std::vector<Vector> values;     // f(x + e d), e = taylor_step 2^-k
    std::vector<Vector> quotients;  // at steps step 2^-k
};

inline Samples sample(const Map& f, const Vector& x, const Vector& d, const Options& o) {
    Samples s{d, f(x), {}, {}};
    for (int k = 0; k < 10; ++k) s.values.push_back(f(along(x, o.taylor_step * std::ldexp(1.0, -k), d)));
    for (int k = 0; k < 8; ++k) s.quotients.push_back(quotient(f, x, d, o.step * std::ldexp(1.0, -k), o.one_sided));
    return s;
}

// The quotient at the step where halving it changes <w, .> least (of all components if w is empty).
inline const Vector& tangent(const Samples& s, const Vector& w) {
    std::size_t best = 1;
    double least = 1e300;
    for (std::size_t k = 1; k < s.quotients.size(); ++k) {
        const Vector change = along(s.quotients[k], -1.0, s.quotients[k - 1]);
        const double size = w.empty() ? norm(change) : std::fabs(dot(w, change));
        if (size < least) least = size, best = k;
    }
    return s.quotients[best];
}

inline void require(bool good, const std::string& text, double got, double expected) {
    if (!good) throw std::runtime_error(text + ": " + std::to_string(got) + ", expected " + std::to_string(expected));
}

inline void check_taylor(const std::string& name, const Samples& s, const Vector& w, double slope, const Options& o) {
    double scale = 0.0;
    for (std::size_t k = 0; k < w.size(); ++k) scale += std::fabs(w[k] * s.f0[k]);
    std::vector<double> remainder;
    for (std::size_t k = 0; k < s.values.size(); ++k) {
        const double e = o.taylor_step * std::ldexp(1.0, -static_cast<int>(k));
        const double r = std::fabs(dot(w, along(s.values[k], -1.0, s.f0)) - e * slope);
        if (o.affine) {
            require(r <= 100 * o.noise * scale, name + ": remainder of an affine map", r, 0.0);
            continue;
        }
        if (r < 100 * o.noise * scale) break;  // noise from here on
        remainder.push_back(r);
    }
    if (o.affine) return;
    require(remainder.size() >= 4, name + ": steps above the noise", static_cast<double>(remainder.size()), 4);
    for (std::size_t k = remainder.size() - 3; k < remainder.size(); ++k) {
        const double order = std::log2(remainder[k - 1] / remainder[k]);
        require(std::fabs(order - 2.0) <= 0.1, name + ": slope of the Taylor remainder", order, 2.0);
    }
}

inline void check_differences(const std::string& name, const Samples& s, const Vector& w, double slope,
                              const Options& o) {
    const double by_difference = dot(w, tangent(s, w));
    require(std::fabs(slope - by_difference) <= o.relative * std::fabs(slope),
            name + ": relative error against differences", slope / by_difference - 1.0, 0.0);
}

inline void check_dot_product(const std::string& name, const Samples& s, const Vector& w, const Vector& gradient,
                              const Options& o) {
    const double size = norm(gradient) * norm(s.direction);
    const double error = (dot(gradient, s.direction) - dot(w, tangent(s, {}))) / size;
    require(std::fabs(error) <= o.relative, name + ": <pullback(w), d> - <w, J d>", error, 0.0);
}

// All three, for two covectors and two directions each.
inline void check_pullback(const std::string& name, const Map& f, const Pullback& pullback, const Vector& x,
                           const Options& o = {}) {
    Random random(o.seed);
    const std::size_t outputs = f(x).size();
    std::vector<Samples> samples;
    for (const Vector& d : o.directions) samples.push_back(sample(f, x, d, o));
    for (int round = 0; round < 2; ++round) {
        const Vector w = random.vector(outputs);
        const Vector gradient = pullback(x, w);
        if (gradient.size() != x.size()) throw std::runtime_error(name + ": pullback of another size than x");
        const double size = norm(gradient);
        require(size > 0 && std::isfinite(size), name + ": norm of the gradient", size, 1.0);
        if (o.directions.empty()) {
            samples.clear();
            for (int k = 0; k < 2; ++k) {
                const Vector r = random.vector(x.size());
                samples.push_back(
                    sample(f, x, along(along(Vector(x.size(), 0.0), 1.0 / norm(r), r), 0.5 / size, gradient), o));
            }
        }
        for (const Samples& s : samples) {
            const double slope = dot(gradient, s.direction);
            require(std::fabs(slope) > 1e-4 * size * norm(s.direction),
                    name + ": gradient along d, relative to its size", slope / (size * norm(s.direction)), 1.0);
            check_taylor(name, s, w, slope, o);
            check_differences(name, s, w, slope, o);
            check_dot_product(name, s, w, gradient, o);
        }
    }
}

}  // namespace derivative
