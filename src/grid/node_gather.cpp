// SPDX-License-Identifier: MIT
#include "grid/node_gather.hpp"

#include <stdexcept>

namespace dqa {

NodeGather::NodeGather(int n_nodes, const std::vector<int>& node, const std::vector<int>& place)
    : start_(static_cast<std::size_t>(n_nodes) + 1, 0), place_(node.size()) {
    for (const int n : node) ++start_[static_cast<std::size_t>(n) + 1];
    for (std::size_t n = 1; n < start_.size(); ++n) start_[n] += start_[n - 1];
    std::vector<int> fill(start_.begin(), start_.end() - 1);
    for (std::size_t k = 0; k < node.size(); ++k)
        place_[static_cast<std::size_t>(fill[static_cast<std::size_t>(node[k])]++)] = place[k];
}

ChunkedGather::ChunkedGather(int n_nodes, const std::vector<int>& nodes, int corners, int n_elements, int grain)
    : slots_(nodes.size()) {
    constexpr int kLanes = 8;
    if (grain * kLanes * corners * 4 > 1 << 16) throw std::length_error("a chunk has more nodes than slots can tell");
    const int n_blocks = static_cast<int>(nodes.size()) / (kLanes * corners);
    std::vector<int> slot(static_cast<std::size_t>(n_nodes), -1), node, place;
    for (int first = 0; first < n_blocks; first += grain) {
        const int last = std::min(first + grain, n_blocks);
        const std::size_t start = begin_.back(), known = node.size();
        // Slots in the order of the elements: those that are added to together lie together.
        for (int e = first * kLanes; e < last * kLanes; ++e)
            for (int corner = 0; corner < corners; ++corner) {
                const std::size_t at = static_cast<std::size_t>((e / kLanes * corners + corner) * kLanes + e % kLanes);
                int& s = slot[static_cast<std::size_t>(nodes[at] / 3)];
                if (s < 0 && e < n_elements) {
                    s = static_cast<int>(node.size() - known);
                    node.push_back(nodes[at] / 3);
                    place.push_back(static_cast<int>(start) + 4 * s);
                }
                slots_[at] = static_cast<std::uint16_t>(4 * s);
            }
        for (std::size_t k = known; k < node.size(); ++k) slot[static_cast<std::size_t>(node[k])] = -1;
        begin_.push_back(start + 4 * (node.size() - known));
    }
    gather_ = NodeGather(n_nodes, node, place);
}

}  // namespace dqa
