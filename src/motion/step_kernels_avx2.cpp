// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE step_kernels_avx2
#include "motion/step_kernels_source.hpp"
