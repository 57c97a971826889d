// SPDX-License-Identifier: MIT
// Which instruction set the kernels run with: each kernel source is compiled once per set and chosen at run time, so
// that a library built once is fast on every x86-64.
#pragma once

namespace dqa {

enum class InstructionSet : int { automatic = 0, baseline = 1, avx2 = 2, avx512 = 3 };

// The best set of this processor, or `wanted` if the processor has it (otherwise the best below it).
InstructionSet choose_instruction_set(InstructionSet wanted);

// From now on the best set is taken to be no better than this, by all that are made later. For tests, which try every
// set of the processor that they run on; not beside other threads.
void limit_instruction_sets(InstructionSet most);

// The table of a kernel source for an instruction set, from the functions that return it: prefix_baseline, and where
// the build has them prefix_avx2 and prefix_avx512.
template <class Table>
const Table& choose_table(InstructionSet set, const Table& (*baseline)(), const Table& (*avx2)(),
                          const Table& (*avx512)()) {
    switch (choose_instruction_set(set)) {
        case InstructionSet::avx512:
            return avx512();
        case InstructionSet::avx2:
            return avx2();
        default:
            return baseline();
    }
}
#if defined(DQA_ONLY_BASELINE_KERNELS)
#define DQA_CHOOSE_TABLE(set, prefix) choose_table(set, prefix##_baseline, prefix##_baseline, prefix##_baseline)
#else
#define DQA_CHOOSE_TABLE(set, prefix) choose_table(set, prefix##_baseline, prefix##_avx2, prefix##_avx512)
#endif

}  // namespace dqa
