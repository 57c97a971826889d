// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE water_kernels_baseline
#include "water/kernels_source.hpp"
