// SPDX-License-Identifier: MIT
#include "shape/transport.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace dqa {
namespace {

constexpr int kGrain = 4096;

}  // namespace

Transport::Transport(const GaussianKernel& kernel, const Densities& bases, std::vector<char> logarithmic,
                     Threads threads)
    : kernel_(kernel),
      bases_(bases),
      logarithmic_(std::move(logarithmic)),
      threads_(threads),
      n_(static_cast<std::size_t>(kernel.size())),
      kernels_(barycenter_kernels(InstructionSet::automatic)),
      planes_(std::make_unique_for_overwrite<double[]>((threads.count > 1 ? bases.size() : 1) * n_)) {
    const auto [nx, ny, nz] = kernel.cells();
    for (const std::vector<double>& p : bases) {
        std::vector<int> rows(2 * static_cast<std::size_t>(nx), 0);
        int first = nx, last = 0;
        for (int x = 0; x < nx; ++x) {
            int least = ny, most = 0;
            for (int y = 0; y < ny; ++y) {
                const auto line = p.begin() + (static_cast<long>(x) * ny + y) * nz;
                if (std::any_of(line, line + nz, [](double q) { return q > 0; }))
                    least = std::min(least, y), most = y + 1;
            }
            if (most == 0) continue;
            first = std::min(first, x), last = x + 1;
            rows[2 * static_cast<std::size_t>(x)] = least, rows[2 * static_cast<std::size_t>(x) + 1] = most;
        }
        rows_.push_back(std::move(rows));
        covers_.push_back({first, last, rows_.back().data()});
    }
}

bool Transport::covers(std::size_t i, std::size_t c) const {
    const auto [nx, ny, nz] = kernel_.cells();
    (void)nx;
    const int x = static_cast<int>(c) / (ny * nz), y = static_cast<int>(c) / nz % ny;
    return y >= rows_[i][2 * static_cast<std::size_t>(x)] && y < rows_[i][2 * static_cast<std::size_t>(x) + 1];
}

// One thread takes base after base, whose arrays then stay in its cache; more of them share each of the three passes.
template <class Forward, class Slab, class Backward>
void Transport::run(const std::vector<std::size_t>& listed, Forward&& forward, Slab&& slab, Backward&& backward) const {
    const auto [nx, ny, nz] = kernel_.cells();
    const int plane = ny * nz, blocks = (plane + kColumnBlock - 1) / kColumnBlock;
    const std::size_t scratch_size = static_cast<std::size_t>(std::max(2 * nx * kColumnBlock, 3 * ny * padded_z(nz)));
    const std::size_t together = threads_.count > 1 ? listed.size() : 1;
    for (std::size_t k0 = 0; k0 < listed.size(); k0 += together) {
        const auto pass = [&](int pieces, auto&& f) {
            parallel_chunks(threads_, static_cast<int>(together) * pieces, 1, [&](int begin, int end) {
                const auto scratch = std::make_unique_for_overwrite<double[]>(scratch_size);
                for (int piece = begin; piece < end; ++piece) {
                    const std::size_t k = static_cast<std::size_t>(piece / pieces);
                    f(listed[k0 + k], planes_.get() + k * n_, piece % pieces, scratch.get());
                }
            });
        };
        const auto columns = [&](int block) {
            return std::array<int, 2>{block * kColumnBlock, std::min(plane, (block + 1) * kColumnBlock)};
        };
        pass(blocks, [&](std::size_t k, double* at, int block, double* scratch) {
            const auto [c0, c1] = columns(block);
            forward(k, at, c0, c1, scratch);
        });
        pass(nx, [&](std::size_t k, double* at, int x, double* scratch) { slab(k, at, x, scratch); });
        pass(blocks, [&](std::size_t k, double* at, int block, double* scratch) {
            const auto [c0, c1] = columns(block);
            backward(k, at, c0, c1, scratch);
        });
    }
}

void Transport::sweep(const double* x, double* kv, double* w, double* log_d, double floor) const {
    std::vector<std::size_t> linear;
    for (std::size_t i = 0; i < bases_.size(); ++i) {
        if (!logarithmic(i)) {
            linear.push_back(i);
            continue;
        }
        const std::size_t at = i * n_;
        kernel_.apply_log(x + at, kv + at, nullptr, threads_);
        for (std::size_t c = 0; c < n_; ++c)
            w[at + c] =
                bases_[i][c] > 0 ? std::log(bases_[i][c]) - kv[at + c] : -std::numeric_limits<double>::infinity();
        kernel_.apply_log(w + at, log_d + at, nullptr, threads_);
    }
    const GaussianGrid grid = kernel_.grid();
    const std::size_t plane = static_cast<std::size_t>(grid.cells[1]) * static_cast<std::size_t>(grid.cells[2]);
    run(
        linear,
        [&](std::size_t i, double* a, int c0, int c1, double* scratch) {
            kernels_.forward_columns(grid, covers_[i], x + i * n_, nullptr, a, c0, c1, scratch);
        },
        [&](std::size_t i, double* a, int s, double* scratch) {
            if (s < covers_[i].first || s >= covers_[i].last) return;
            const std::size_t at = static_cast<std::size_t>(s) * plane;
            kernels_.slab(grid, covers_[i], s, bases_[i].data() + at, nullptr, kv + i * n_ + at, w + i * n_ + at,
                          a + at, scratch);
        },
        [&](std::size_t i, double* a, int c0, int c1, double* scratch) {
            kernels_.backward_columns(grid, covers_[i], a, nullptr, nullptr, floor, log_d + i * n_, c0, c1, scratch);
        });
}

Jacobian::Jacobian(const Transport& transport, const double* x, const double* kv, const double* w, const double* log_d)
    : t_(transport) {
    const std::size_t n = t_.n_, size = t_.bases() * n;
    v_.resize(size), w_.resize(size), ratio_.resize(size), inv_d_.resize(size);
    for (std::size_t i = 0; i < t_.bases(); ++i) {
        const std::size_t first = i * n;
        if (t_.logarithmic(i)) {
            std::copy_n(x + first, n, v_.data() + first);
            std::copy_n(w + first, n, w_.data() + first);
            continue;
        }
        parallel_chunks(t_.threads_, static_cast<int>(n), kGrain, [&](int begin, int end) {
            const std::size_t at = first + static_cast<std::size_t>(begin);
            const int count = end - begin;
            t_.kernels_.exp(x + at, v_.data() + at, count);
            std::vector<double> minus(static_cast<std::size_t>(count));  // not on a stack that may be small
            for (int k = 0; k < count; ++k)
                minus[static_cast<std::size_t>(k)] = -log_d[at + static_cast<std::size_t>(k)];
            t_.kernels_.exp(minus.data(), inv_d_.data() + at, count);
        });
    }
    const int nx = t_.kernel_.cells()[0], ny = t_.kernel_.cells()[1], nz = t_.kernel_.cells()[2];
    parallel_chunks(t_.threads_, static_cast<int>(t_.bases()) * nx, 1, [&](int begin, int end) {
        for (int slab = begin; slab < end; ++slab) {
            const std::size_t i = static_cast<std::size_t>(slab / nx), s = static_cast<std::size_t>(slab % nx);
            if (t_.logarithmic(i)) continue;
            const std::size_t at = static_cast<std::size_t>(slab) * static_cast<std::size_t>(ny * nz);
            const int* rows = t_.rows_[i].data() + 2 * s;
            for (std::size_t k = at + static_cast<std::size_t>(rows[0] * nz);
                 k < at + static_cast<std::size_t>(rows[1] * nz); ++k)
                w_[k] = w[k], ratio_[k] = 1.0 / kv[k];
        }
    });
}

void Jacobian::laplacian(const std::vector<std::size_t>& which, const double* in, double* out) const {
    const std::size_t n = t_.n_;
    std::vector<std::size_t> linear;
    std::vector<double> means;
    for (std::size_t k = 0; k < which.size(); ++k) {
        const std::size_t i = which[k];
        if (!t_.logarithmic(i)) {
            linear.push_back(k);
            continue;
        }
        // Two kernel means: over v, then over w; each keeps its own scale and cannot underflow.
        means.resize(n);
        double* to = out + k * n;
        std::copy(in + k * n, in + (k + 1) * n, to);
        t_.kernel_.apply_log(v_.data() + i * n, means.data(), to, t_.threads_);
        t_.kernel_.apply_log(w_.data() + i * n, means.data(), to, t_.threads_);
        for (std::size_t c = 0; c < n; ++c) to[c] = in[k * n + c] - to[c];
    }
    const GaussianGrid grid = t_.kernel_.grid();
    const std::size_t plane = static_cast<std::size_t>(grid.cells[1]) * static_cast<std::size_t>(grid.cells[2]);
    t_.run(
        linear,
        [&](std::size_t k, double* a, int c0, int c1, double* scratch) {
            t_.kernels_.forward_columns(grid, t_.covers_[which[k]], in + k * n, v_.data() + which[k] * n, a, c0, c1,
                                        scratch);
        },
        [&](std::size_t k, double* a, int s, double* scratch) {
            const std::size_t i = which[k], at = static_cast<std::size_t>(s) * plane;
            if (s < t_.covers_[i].first || s >= t_.covers_[i].last) return;
            t_.kernels_.slab(grid, t_.covers_[i], s, w_.data() + i * n + at, ratio_.data() + i * n + at, nullptr,
                             nullptr, a + at, scratch);
        },
        [&](std::size_t k, double* a, int c0, int c1, double* scratch) {
            t_.kernels_.backward_columns(grid, t_.covers_[which[k]], a, inv_d_.data() + which[k] * n, in + k * n, 0.0,
                                         out + k * n, c0, c1, scratch);
        });
}

}  // namespace dqa
