// SPDX-License-Identifier: MIT
#include "linalg/grid_kernels.hpp"

namespace dqa {

const GridTables& grid_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, grid_kernels);
}

}  // namespace dqa
