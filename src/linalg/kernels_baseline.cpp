// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE linalg_kernels_baseline
#include "linalg/kernels_source.hpp"
