// SPDX-License-Identifier: MIT
// Normal numbers by the polar method (Marsaglia & Bray 1964). The logarithm is our own: those of C libraries differ in
// the last bit, and a search would take another way on another system. +, -, *, / and square roots round alike wherever
// IEEE 754 holds and the compiler fuses no products into sums, for which baseline x86-64 has no instruction.
#pragma once

#include <cmath>

#include "grid/random.hpp"

namespace dqa {

// ln x for normal numbers x > 0, to a few units in the last place: x = m 2^e, ln m = 2 artanh((m - 1) / (m + 1)).
inline double portable_log(double x) {
    int e;
    double m = std::frexp(x, &e);  // exact
    if (m < 0.70710678118654752) m *= 2, --e;
    const double s = (m - 1) / (m + 1), s2 = s * s;  // |s| < 0.172: the term after the last is below 2^-56 of the sum
    double sum = 0;
    for (int k = 21; k >= 1; k -= 2) sum = sum * s2 + 1.0 / k;
    return 2 * s * sum + e * 0.69314718055994531;
}

class NormalNumbers {
public:
    explicit NormalNumbers(Random& random) : random_(random) {}
    double operator()() {
        if (has_spare_) {
            has_spare_ = false;
            return spare_;
        }
        double u, v, r;
        do {
            u = random_(), v = random_();
            r = u * u + v * v;
        } while (r >= 1 || r == 0);
        const double factor = std::sqrt(-2 * portable_log(r) / r);
        spare_ = v * factor, has_spare_ = true;
        return u * factor;
    }

private:
    Random& random_;
    double spare_ = 0;
    bool has_spare_ = false;
};

}  // namespace dqa
