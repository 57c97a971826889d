// SPDX-License-Identifier: MIT
// Linked into tests of accuracy and stability, which run once for each instruction set of the processor: where the
// variable DQA_TEST_INSTRUCTION_SET names one (1 baseline, 2 AVX2), all that is made takes no better one. Ends the test
// as skipped where that would try nothing new.
#include <cstdlib>

#include "grid/simd.hpp"

namespace {

using dqa::InstructionSet;

const bool limited = [] {
    const char* wanted = std::getenv("DQA_TEST_INSTRUCTION_SET");
    if (!wanted || !*wanted) return false;
    const auto set = static_cast<InstructionSet>(std::atoi(wanted));
    if (dqa::choose_instruction_set(set) != set || set == dqa::choose_instruction_set(InstructionSet::automatic))
        std::exit(77);
    dqa::limit_instruction_sets(set);
    return true;
}();

}  // namespace
