// SPDX-License-Identifier: MIT
#include "shape/kernels.hpp"

namespace dqa {

const BarycenterKernels& barycenter_kernels(InstructionSet set) {
#if !defined(DQA_ONLY_BASELINE_KERNELS)
    switch (choose_instruction_set(set)) {
        case InstructionSet::avx512:
            return shape_kernels_avx512();
        case InstructionSet::avx2:
            return shape_kernels_avx2();
        default:
            break;
    }
#else
    (void)set;
#endif
    return shape_kernels_baseline();
}

}  // namespace dqa
