// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE grid_kernels_avx2
#include "linalg/grid_kernels_source.hpp"
