// SPDX-License-Identifier: MIT
#include "water/kernels.hpp"

namespace dqa {

const WaterKernels& water_kernels(InstructionSet set) {
#if !defined(DQA_ONLY_BASELINE_KERNELS)
    switch (choose_instruction_set(set)) {
        case InstructionSet::avx512:
            return water_kernels_avx512();
        case InstructionSet::avx2:
            return water_kernels_avx2();
        default:
            break;
    }
#else
    (void)set;
#endif
    return water_kernels_baseline();
}

}  // namespace dqa
