// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE body_kernels_avx2
#include "body/kernels_source.hpp"
