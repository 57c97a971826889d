// SPDX-License-Identifier: MIT
// OpenBLAS takes a buffer of 128 MiB for each thread that is in it and asks for it again and again, without end, where
// the system has none left (blas_memory_alloc of 0.3.21). Whoever calls a factorisation asks before.
#pragma once

namespace dqa {

// While this lives its thread may call what uses BLAS.
class BlasCall {
public:
    BlasCall();  // std::bad_alloc: the memory that OpenBLAS would ask for is not there
    ~BlasCall();
    BlasCall(const BlasCall&) = delete;
    BlasCall& operator=(const BlasCall&) = delete;
};

}  // namespace dqa
