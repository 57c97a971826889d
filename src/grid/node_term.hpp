// SPDX-License-Identifier: MIT
// How the forces of elements reach the nodes, as kernels see it: see node_gather.hpp.
#pragma once

#include <cstdint>

namespace dqa {

// Where elements in blocks of eight lanes leave their forces: on the nodes of their chunk.
template <class T>
struct ChunkForces {
    const std::uint16_t* slots;  // [block][corners][8 lanes]: places in `sum`
    T* sum;                      // [nodes of the chunk][4], added to
};

// What a gather gives to the nodes: node n has the sum of the four numbers (the last 0) at values +
// place[s], s from start[n] to start[n + 1].
template <class T>
struct NodeTerm {
    const int *start, *place;
    const T* values;
};

}  // namespace dqa
