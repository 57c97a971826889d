// SPDX-License-Identifier: MIT
#include "water/kernels.hpp"

namespace dqa {

const WaterKernels& water_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, water_kernels);
}

}  // namespace dqa
