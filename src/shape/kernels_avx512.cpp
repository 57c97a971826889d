// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE shape_kernels_avx512
#include "shape/kernels_source.hpp"
