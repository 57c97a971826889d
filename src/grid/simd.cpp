// SPDX-License-Identifier: MIT
#include "grid/simd.hpp"

#include <algorithm>

namespace dqa {
namespace {

InstructionSet most_allowed = InstructionSet::avx512;

}  // namespace

void limit_instruction_sets(InstructionSet most) {
    most_allowed = most;
}

InstructionSet choose_instruction_set(InstructionSet wanted) {
#if defined(__x86_64__) && !defined(DQA_ONLY_BASELINE_KERNELS)
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                        __builtin_cpu_supports("avx512vl");
    const InstructionSet best = std::min(
        most_allowed, avx512 ? InstructionSet::avx512 : (avx2 ? InstructionSet::avx2 : InstructionSet::baseline));
    if (wanted == InstructionSet::automatic) return best;
    return static_cast<int>(wanted) <= static_cast<int>(best) ? wanted : best;
#else
    (void)wanted;
    return InstructionSet::baseline;
#endif
}

}  // namespace dqa
