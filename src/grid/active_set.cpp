// SPDX-License-Identifier: MIT
#include "grid/active_set.hpp"

#include <algorithm>

#include "grid/parallel.hpp"

namespace dqa {
namespace {

constexpr int kBlockLanes = 8;

}  // namespace

ActiveSet make_active_set(const Box& box, const std::vector<char>& mask) {
    ActiveSet set;
    set.box = box;
    set.cell_to_active.assign(static_cast<std::size_t>(box.n_cells()), -1);
    set.node_to_active.assign(static_cast<std::size_t>(box.n_nodes()), -1);
    for (int c = 0; c < box.n_cells(); ++c) {
        if (!mask[static_cast<std::size_t>(c)]) continue;
        set.cell_to_active[static_cast<std::size_t>(c)] = static_cast<int>(set.cells.size());
        set.cells.push_back(c);
        const auto ijk = box.cell_ijk(c);
        for (int k = 0; k < 8; ++k)
            set.node_to_active[static_cast<std::size_t>(
                box.node(ijk[0] + (k >> 2), ijk[1] + (k >> 1 & 1), ijk[2] + (k & 1)))] = 0;
    }
    for (int i = 0; i <= box.cells[0]; ++i)
        for (int j = 0; j <= box.cells[1]; ++j)
            for (int k = 0; k < box.node_planes(); ++k) {
                int& node = set.node_to_active[static_cast<std::size_t>(box.node(i, j, k))];
                if (node < 0) continue;
                node = static_cast<int>(set.node_ijk.size());
                set.node_ijk.push_back({i, j, k});
            }
    for (const int c : set.cells) {
        const auto ijk = box.cell_ijk(c);
        std::array<int, 8> nodes{};
        for (int k = 0; k < 8; ++k)
            nodes[static_cast<std::size_t>(k)] = set.node_to_active[static_cast<std::size_t>(
                box.node(ijk[0] + (k >> 2), ijk[1] + (k >> 1 & 1), ijk[2] + (k & 1)))];
        set.cell_nodes.push_back(nodes);
    }
    return set;
}

std::vector<double> ActiveSet::rest_positions() const {
    std::vector<double> q;
    q.reserve(3 * node_ijk.size());
    for (const auto& ijk : node_ijk)
        for (const double x : box.node_position(ijk[0], ijk[1], ijk[2])) q.push_back(x);
    return q;
}

BlockLayout::BlockLayout(const ActiveSet& set, const std::vector<int>& element_cells)
    : n_elements_(static_cast<int>(element_cells.size())),
      n_blocks_((n_elements_ + kBlockLanes - 1) / kBlockLanes),
      n_nodes_(set.n_nodes()),
      nodes_(static_cast<std::size_t>(n_blocks_) * 64, 0),
      start_(static_cast<std::size_t>(n_nodes_) + 1, 0) {
    for (int e = 0; e < n_blocks_ * kBlockLanes; ++e) {
        const int cell = element_cells[static_cast<std::size_t>(std::min(e, n_elements_ - 1))];
        for (int k = 0; k < 8; ++k)
            nodes_[static_cast<std::size_t>((e / 8) * 64 + k * 8 + e % 8)] =
                3 * set.cell_nodes[static_cast<std::size_t>(cell)][static_cast<std::size_t>(k)];
    }
    for (int e = 0; e < n_elements_; ++e)
        for (int k = 0; k < 8; ++k)
            ++start_[static_cast<std::size_t>(nodes_[static_cast<std::size_t>((e / 8) * 64 + k * 8 + e % 8)] / 3) + 1];
    for (int n = 0; n < n_nodes_; ++n) start_[static_cast<std::size_t>(n) + 1] += start_[static_cast<std::size_t>(n)];
    slot_.resize(static_cast<std::size_t>(n_elements_) * 8);
    std::vector<int> fill(start_.begin(), start_.end() - 1);
    for (int e = 0; e < n_elements_; ++e)
        for (int k = 0; k < 8; ++k) {
            const std::size_t node =
                static_cast<std::size_t>(nodes_[static_cast<std::size_t>((e / 8) * 64 + k * 8 + e % 8)] / 3);
            slot_[static_cast<std::size_t>(fill[node]++)] = ((e / 8) * 8 + k) * 24 + e % 8;
        }
}

void BlockLayout::add_to_nodes(const double* element_force, double* out, Threads threads) const {
    parallel_chunks(threads, n_nodes_, 512, [&](int begin, int end) {
        for (int n = begin; n < end; ++n) {
            double x = 0.0, y = 0.0, z = 0.0;
            for (int s = start_[static_cast<std::size_t>(n)]; s < start_[static_cast<std::size_t>(n) + 1]; ++s) {
                const double* f = element_force + slot_[static_cast<std::size_t>(s)];
                x += f[0], y += f[8], z += f[16];
            }
            out[3 * n] += x, out[3 * n + 1] += y, out[3 * n + 2] += z;
        }
    });
}

std::vector<double> BlockLayout::blocked(const std::vector<double>& values) const {
    std::vector<double> out(static_cast<std::size_t>(n_blocks_) * kBlockLanes, 0.0);
    std::copy(values.begin(), values.end(), out.begin());
    return out;
}

}  // namespace dqa
