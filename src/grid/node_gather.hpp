// SPDX-License-Identifier: MIT
// Sums what elements (cells, fibres, faces) give to their corners onto the nodes: node by node and in the order of the
// elements, so that the bits are the same for any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grid/node_term.hpp"
#include "grid/parallel.hpp"

namespace dqa {

constexpr int kNodeGrain = 64;  // nodes a chunk

// out[node][3] += what the term gives to it, for nodes [begin, end).
template <class T>
void add_term(const NodeTerm<T>& term, int begin, int end, T* out) {
    for (int n = begin; n < end; ++n) {
        T sum[3] = {};
        for (int s = term.start[n]; s < term.start[n + 1]; ++s)
            for (int k = 0; k < 3; ++k) sum[k] += term.values[term.place[s] + k];
        for (int k = 0; k < 3; ++k) out[3 * n + k] += sum[k];
    }
}
// The same of several terms, for all nodes.
template <class T>
void add_terms(const std::vector<NodeTerm<T>>& terms, int n_nodes, Threads threads, T* out) {
    parallel_chunks(threads, n_nodes, kNodeGrain, [&](int begin, int end) {
        for (const NodeTerm<T>& term : terms) add_term(term, begin, end, out);
    });
}

class NodeGather {
public:
    NodeGather() = default;
    // Entry k: node[k] receives the vector at place[k] of the element array, where four numbers are read.
    NodeGather(int n_nodes, const std::vector<int>& node, const std::vector<int>& place);

    // f(place) for the node's entries, in the order of the sums.
    template <class F>
    void each(int node, F&& f) const {
        for (int s = start_[static_cast<std::size_t>(node)]; s < start_[static_cast<std::size_t>(node) + 1]; ++s)
            f(place_[static_cast<std::size_t>(s)]);
    }

    template <class T>
    NodeTerm<T> term(const T* values) const {
        return {start_.data(), place_.data(), values};
    }
    int n_nodes() const { return static_cast<int>(start_.size()) - 1; }

private:
    std::vector<int> start_, place_;  // compressed rows: entries of each node
};

// The same in two stages for elements in blocks of eight: a kernel adds up what the elements of a chunk give to the
// nodes of that chunk, which stay in cache, and the nodes gather from the few chunks around them. Neighbours share most
// nodes, so that far less passes through memory than a vector per corner.
class ChunkedGather {
public:
    ChunkedGather() = default;
    // nodes: 3 * node as [block][corners][8 lanes], of which n_elements lanes count; a chunk is `grain` blocks.
    ChunkedGather(int n_nodes, const std::vector<int>& nodes, int corners, int n_elements, int grain);

    int n_chunks() const { return static_cast<int>(begin_.size()) - 1; }
    // Numbers of all chunks' sums, [node of a chunk][4].
    std::size_t size() const { return begin_.back(); }
    // Those of chunk k, set to zero for a kernel to add to.
    template <class T>
    ChunkForces<T> cleared(int k, std::vector<T>& sums) const {
        const auto at = sums.begin();
        const auto offset = [&](int chunk) {
            return static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(chunk)]);
        };
        std::fill(at + offset(k), at + offset(k + 1), T(0));
        return {slots_.data(), sums.data() + offset(k)};
    }
    const NodeGather& gather() const { return gather_; }

private:
    std::vector<std::uint16_t> slots_;  // 4 * (node within its chunk), [block][corners][8 lanes]
    std::vector<std::size_t> begin_ = {0};
    NodeGather gather_;
};

}  // namespace dqa
