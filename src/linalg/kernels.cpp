// SPDX-License-Identifier: MIT
#include "linalg/kernels.hpp"

namespace dqa {

const LinalgKernels& linalg_kernels(InstructionSet set) {
#if !defined(DQA_ONLY_BASELINE_KERNELS)
    switch (choose_instruction_set(set)) {
        case InstructionSet::avx512:
            return linalg_kernels_avx512();
        case InstructionSet::avx2:
            return linalg_kernels_avx2();
        default:
            break;
    }
#else
    (void)set;
#endif
    return linalg_kernels_baseline();
}

}  // namespace dqa
