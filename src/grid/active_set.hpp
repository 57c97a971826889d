// SPDX-License-Identifier: MIT
// The cells that a scene needs, their nodes, and the blocked layout in which kernels walk them.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"
#include "grid/node_gather.hpp"
#include "grid/parallel.hpp"

namespace dqa {

struct ActiveSet {
    Box box;
    std::vector<int> cells;                      // box index of each active cell, ascending
    std::vector<int> cell_to_active;             // box index -> active index or -1
    std::vector<int> node_to_active;             // box node -> active node or -1
    std::vector<std::array<int, 3>> node_ijk;    // grid coordinates of each active node
    std::vector<std::array<int, 8>> cell_nodes;  // active nodes of each cell; corner 4 ix + 2 iy + iz
    // Cells around each node, ascending: node_cells[node_cell_start[n]] up to node_cell_start[n + 1].
    std::vector<int> node_cell_start, node_cells;

    int n_cells() const { return static_cast<int>(cells.size()); }
    int n_nodes() const { return static_cast<int>(node_ijk.size()); }
    // Rest positions [n_nodes][3] (m).
    std::vector<double> rest_positions() const;
};

ActiveSet make_active_set(const Box& box, const std::vector<char>& mask);

// A list of elements (cells; a cell may occur several times) in blocks of 8 lanes, and the transposed map from element
// forces onto nodes.
class BlockLayout {
public:
    // element_cells: active cell of each element; a chunk is `grain` blocks.
    BlockLayout(const ActiveSet& set, const std::vector<int>& element_cells, int grain);

    int n_elements() const { return n_elements_; }
    int n_blocks() const { return n_blocks_; }
    // 3 * node as [block][8 corners][8 lanes]; padding lanes repeat the last element.
    const int* nodes() const { return nodes_.data(); }
    // Sums what the elements give to their corners onto nodes, by way of the chunks.
    const ChunkedGather& sums() const { return sums_; }
    // values [n_elements] -> [block][8], padding lanes 0.
    std::vector<double> blocked(const std::vector<double>& values) const;

private:
    int n_elements_, n_blocks_;
    std::vector<int> nodes_;
    ChunkedGather sums_;
};

}  // namespace dqa
