// SPDX-License-Identifier: MIT
// Sums what elements (cells, fibres, faces) give to their corners onto the nodes: node by node and in the order of the
// elements, so that the bits are the same for any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grid/four.hpp"
#include "grid/parallel.hpp"

namespace dqa {

constexpr int kNodeGrain = 64;  // nodes a chunk

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

    int n_nodes() const { return static_cast<int>(start_.size()) - 1; }
    // out[node][3] += scale * sum of the node's entries, for nodes [begin, end).
    template <class T>
    void add(const T* values, T scale, int begin, int end, T* out) const {
        for (int n = begin; n < end; ++n) {
            const int first = start_[static_cast<std::size_t>(n)], last = start_[static_cast<std::size_t>(n) + 1];
            const auto value = [&](int s) { return values + place_[static_cast<std::size_t>(s)]; };
            if constexpr (sizeof(T) == sizeof(float)) {
                Four<T> sum = {};  // a register of any x86-64
                for (int s = first; s < last; ++s) sum += four(value(s));
                for (int k = 0; k < 3; ++k) out[3 * n + k] += scale * sum[k];
            } else {
                T x = 0, y = 0, z = 0;
                for (int s = first; s < last; ++s) {
                    const T* v = value(s);
                    x += v[0], y += v[1], z += v[2];
                }
                out[3 * n] += scale * x, out[3 * n + 1] += scale * y, out[3 * n + 2] += scale * z;
            }
        }
    }

private:
    std::vector<int> start_, place_;  // compressed rows: entries of each node
};

// The same in two stages for elements of eight corners in blocks of eight: a kernel adds up what the elements of a
// chunk give to the nodes of that chunk, which stay in cache, and the nodes gather from the few chunks around them.
// Neighbours share most nodes, so that far less passes through memory than a vector per corner.
class ChunkedGather {
public:
    ChunkedGather() = default;
    // nodes: 3 * node as [block][8 corners][8 lanes], of which n_elements lanes count; a chunk is `grain` blocks.
    ChunkedGather(int n_nodes, const std::vector<int>& nodes, int n_elements, int grain);

    int n_chunks() const { return static_cast<int>(begin_.size()) - 1; }
    // 4 * (node within its chunk), [block][8 corners][8 lanes].
    const std::uint16_t* slots() const { return slots_.data(); }
    // Numbers of all chunks' sums, [node of a chunk][4].
    std::size_t size() const { return begin_.back(); }
    // Those of chunk k, set to zero.
    template <class T>
    T* cleared(int k, std::vector<T>& sums) const {
        const auto at = sums.begin();
        const auto offset = [&](int chunk) {
            return static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(chunk)]);
        };
        std::fill(at + offset(k), at + offset(k + 1), T(0));
        return sums.data() + offset(k);
    }
    const NodeGather& gather() const { return gather_; }

private:
    std::vector<std::uint16_t> slots_;
    std::vector<std::size_t> begin_ = {0};
    NodeGather gather_;
};

}  // namespace dqa
