// SPDX-License-Identifier: MIT
#include "linalg/nested_dissection.hpp"

#include <algorithm>
#include <numeric>

namespace dqa {
namespace {

constexpr std::size_t kLeaf = 24;

void dissect(const std::vector<std::array<int, 3>>& nodes, std::vector<int>& part, std::vector<int>& order) {
    if (part.size() <= kLeaf) {
        order.insert(order.end(), part.begin(), part.end());
        return;
    }
    // Among the three axes, the median plane with the fewest nodes; it must leave something on both sides.
    std::size_t best_axis = 3, best_size = part.size();
    int best_plane = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<int> coordinate;
        coordinate.reserve(part.size());
        for (const int n : part) coordinate.push_back(nodes[static_cast<std::size_t>(n)][axis]);
        std::nth_element(coordinate.begin(), coordinate.begin() + static_cast<long>(part.size() / 2), coordinate.end());
        const int plane = coordinate[part.size() / 2];
        std::size_t on = 0, below = 0;
        for (const int c : coordinate) on += c == plane, below += c < plane;
        if (below == 0 || below + on == part.size()) continue;
        if (on < best_size) best_size = on, best_axis = axis, best_plane = plane;
    }
    if (best_axis == 3) {
        order.insert(order.end(), part.begin(), part.end());
        return;
    }
    std::vector<int> low, high, separator;
    for (const int n : part) {
        const int c = nodes[static_cast<std::size_t>(n)][best_axis];
        (c < best_plane ? low : (c > best_plane ? high : separator)).push_back(n);
    }
    part.clear();
    part.shrink_to_fit();
    dissect(nodes, low, order);
    dissect(nodes, high, order);
    dissect(nodes, separator, order);  // a separator's own order matters little, but keeps its neighbours close
}

}  // namespace

std::vector<int> nested_dissection(const std::vector<std::array<int, 3>>& nodes) {
    std::vector<int> all(nodes.size()), order;
    std::iota(all.begin(), all.end(), 0);
    order.reserve(nodes.size());
    dissect(nodes, all, order);
    return order;
}

}  // namespace dqa
