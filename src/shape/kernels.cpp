// SPDX-License-Identifier: MIT
#include "shape/kernels.hpp"

namespace dqa {

const BarycenterKernels& barycenter_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, shape_kernels);
}

}  // namespace dqa
