// SPDX-License-Identifier: MIT
#include "motion/step_kernels.hpp"

namespace dqa {

const StepKernels& step_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, step_kernels);
}

}  // namespace dqa
