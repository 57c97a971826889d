// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE linalg_kernels_avx512
#include "linalg/kernels_source.hpp"
