// SPDX-License-Identifier: MIT
// Which instruction set the kernels run with: each kernel source is compiled once per set and chosen at run time, so
// that a library built once is fast on every x86-64.
#pragma once

namespace dqa {

enum class InstructionSet : int { automatic = 0, baseline = 1, avx2 = 2, avx512 = 3 };

// The best set of this processor, or `wanted` if the processor has it (otherwise the best below it).
InstructionSet choose_instruction_set(InstructionSet wanted);

}  // namespace dqa
