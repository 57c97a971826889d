// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE body_kernels_baseline
#include "body/kernels_source.hpp"
