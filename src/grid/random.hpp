// SPDX-License-Identifier: MIT
// splitmix64 (Steele, Lea & Flood 2014): the same numbers on every platform for the same seed.
#pragma once

#include <cstdint>

namespace dqa {

struct Random {
    std::uint64_t state;
    // Uniform in (-1, 1).
    double operator()() {
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        z ^= z >> 31;
        return 2.0 * (static_cast<double>(z >> 11) + 0.5) / 9007199254740992.0 - 1.0;
    }
};

}  // namespace dqa
