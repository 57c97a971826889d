// SPDX-License-Identifier: MIT
#include "linalg/kernels.hpp"

namespace dqa {

const LinalgKernels& linalg_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, linalg_kernels);
}

}  // namespace dqa
