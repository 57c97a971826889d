// SPDX-License-Identifier: MIT
#include "grid/active_set.hpp"

#include <algorithm>

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
    set.node_cell_start.assign(set.node_ijk.size() + 1, 0);
    for (const auto& nodes : set.cell_nodes)
        for (const int n : nodes) ++set.node_cell_start[static_cast<std::size_t>(n) + 1];
    for (std::size_t n = 1; n < set.node_cell_start.size(); ++n) set.node_cell_start[n] += set.node_cell_start[n - 1];
    std::vector<int> fill(set.node_cell_start.begin(), set.node_cell_start.end() - 1);
    set.node_cells.resize(8 * set.cell_nodes.size());
    for (std::size_t c = 0; c < set.cell_nodes.size(); ++c)
        for (const int n : set.cell_nodes[c])
            set.node_cells[static_cast<std::size_t>(fill[static_cast<std::size_t>(n)]++)] = static_cast<int>(c);
    return set;
}

std::vector<double> ActiveSet::rest_positions() const {
    std::vector<double> q;
    q.reserve(3 * node_ijk.size());
    for (const auto& ijk : node_ijk)
        for (const double x : box.node_position(ijk[0], ijk[1], ijk[2])) q.push_back(x);
    return q;
}

BlockLayout::BlockLayout(const ActiveSet& set, const std::vector<int>& element_cells, int grain)
    : n_elements_(static_cast<int>(element_cells.size())),
      n_blocks_((n_elements_ + kBlockLanes - 1) / kBlockLanes),
      nodes_(static_cast<std::size_t>(n_blocks_) * 64, 0) {
    for (int e = 0; e < n_blocks_ * kBlockLanes; ++e) {
        const int cell = element_cells[static_cast<std::size_t>(std::min(e, n_elements_ - 1))];
        for (int k = 0; k < 8; ++k)
            nodes_[static_cast<std::size_t>((e / 8) * 64 + k * 8 + e % 8)] =
                3 * set.cell_nodes[static_cast<std::size_t>(cell)][static_cast<std::size_t>(k)];
    }
    sums_ = ChunkedGather(set.n_nodes(), nodes_, 8, n_elements_, grain);
}

std::vector<double> BlockLayout::blocked(const std::vector<double>& values) const {
    std::vector<double> out(static_cast<std::size_t>(n_blocks_) * kBlockLanes, 0.0);
    std::copy(values.begin(), values.end(), out.begin());
    return out;
}

}  // namespace dqa
