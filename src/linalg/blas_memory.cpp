// SPDX-License-Identifier: MIT
#include "linalg/blas_memory.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <new>

// There only where BLAS is OpenBLAS.
extern "C" __attribute__((weak)) int openblas_get_num_threads(void);

namespace dqa {
namespace {

// Besides its buffer a call needs room for what CHOLMOD allocates before it.
constexpr std::size_t kBuffer = std::size_t(128) << 20, kBesides = std::size_t(16) << 20;

std::atomic<int> inside{0};   // calls under way
std::atomic<int> granted{0};  // buffers that have been there: OpenBLAS keeps what it got

// Address space, and memory where the system promises no more than it has, are what a buffer may lack; its pages are
// only given as they are used.
bool is_there(std::size_t bytes) {
    void* trial = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (trial == MAP_FAILED) return false;
    munmap(trial, bytes);
    return true;
}

}  // namespace

BlasCall::BlasCall() {
    const int helpers = openblas_get_num_threads ? std::max(openblas_get_num_threads() - 1, 0) : 0;
    const int wanted = ++inside + helpers, there = granted;
    if (wanted <= there) return;
    if (!is_there(kBuffer * static_cast<std::size_t>(wanted - there) + kBesides)) {
        --inside;
        throw std::bad_alloc();
    }
    granted = wanted;
}

BlasCall::~BlasCall() {
    --inside;
}

}  // namespace dqa
