// SPDX-License-Identifier: MIT
// What there is in double and in single precision, chosen by the number that a template computes with: x.in(T()).
#pragma once

#include <cstddef>
#include <vector>

namespace dqa {

template <template <class> class Of>
struct InBothPrecisions {
    Of<double> exact{};
    Of<float> single{};
    Of<double>& in(double) { return exact; }
    Of<float>& in(float) { return single; }
    const Of<double>& in(double) const { return exact; }
    const Of<float>& in(float) const { return single; }
};

// A vector with its default allocator: a template of one parameter, as InBothPrecisions wants it.
template <class T>
using Numbers = std::vector<T>;

// Entries [begin, end) of `from` to the same place of `to`.
template <class From, class To>
inline void convert(const std::vector<From>& from, std::vector<To>& to, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) to[i] = static_cast<To>(from[i]);
}

}  // namespace dqa
