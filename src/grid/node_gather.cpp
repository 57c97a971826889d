// SPDX-License-Identifier: MIT
#include "grid/node_gather.hpp"

namespace dqa {

NodeGather::NodeGather(int n_nodes, const std::vector<int>& node, const std::vector<int>& place)
    : start_(static_cast<std::size_t>(n_nodes) + 1, 0), place_(node.size()) {
    for (const int n : node) ++start_[static_cast<std::size_t>(n) + 1];
    for (std::size_t n = 1; n < start_.size(); ++n) start_[n] += start_[n - 1];
    std::vector<int> fill(start_.begin(), start_.end() - 1);
    for (std::size_t k = 0; k < node.size(); ++k)
        place_[static_cast<std::size_t>(fill[static_cast<std::size_t>(node[k])]++)] = place[k];
}

}  // namespace dqa
