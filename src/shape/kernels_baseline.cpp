// SPDX-License-Identifier: MIT
#define DQA_KERNEL_TABLE shape_kernels_baseline
#include "shape/kernels_source.hpp"
