// SPDX-License-Identifier: MIT
// Geometric nested dissection of nodes on a grid with 27-point coupling (George 1973): a plane of nodes across the
// longest side separates the rest. The same fill as graph partitioners here, at a fraction of their time.
#pragma once

#include <array>
#include <vector>

namespace dqa {

// Elimination order: the node index at each position.
std::vector<int> nested_dissection(const std::vector<std::array<int, 3>>& nodes);

}  // namespace dqa
