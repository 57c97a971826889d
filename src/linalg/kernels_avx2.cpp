// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE linalg_kernels_avx2
#include "linalg/kernels_source.hpp"
