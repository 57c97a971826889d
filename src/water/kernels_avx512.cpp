// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE water_kernels_avx512
#include "water/kernels_source.hpp"
