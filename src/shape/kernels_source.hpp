// SPDX-License-Identifier: MIT
// Source of the barycentre's kernels, included once per instruction set; see kernels.hpp.
#include "grid/simd_vector.hpp"
#include "shape/kernels.hpp"

namespace dqa {
namespace {

typedef long long Vi __attribute__((vector_size(kLanes * sizeof(long long)), may_alias));

#if defined(__AVX512F__)
constexpr int kWide = 4;  // registers side by side in a tile of the product
#else
constexpr int kWide = 2;
#endif

constexpr double kShift = 6755399441055744.0;  // 1.5 2^52: adding it leaves an integer in the low bits

inline Vi bits_of(V v) {
    return reinterpret_cast<Vi&>(v);
}
inline V double_of(Vi v) {
    return reinterpret_cast<V&>(v);
}
inline V power_of_two(V shifted) {  // 2^k, k in [-1022, 1023], of k + kShift
    return double_of((bits_of(shifted) + 1023) << 52);
}

// exp(x) = 2^k exp(r), |r| <= ln 2 / 2, by its series: the first term left out is 4e-18. 2^k in two factors, so that
// results next to either end of the range of doubles come out.
inline V exponential(V x) {
    x = select(x > 720.0, broadcast(720.0), x);
    x = select(x < -760.0, broadcast(-760.0), x);
    const V k = (x * 1.4426950408889634074 + kShift) - kShift;
    const V r = (x - k * 0.693147180369123816490) - k * 1.90821492927058770002e-10;  // ln 2 in two parts
    V s = broadcast(1.0 / 6227020800.0);
    s = s * r + 1.0 / 479001600.0;
    s = s * r + 1.0 / 39916800.0;
    s = s * r + 1.0 / 3628800.0;
    s = s * r + 1.0 / 362880.0;
    s = s * r + 1.0 / 40320.0;
    s = s * r + 1.0 / 5040.0;
    s = s * r + 1.0 / 720.0;
    s = s * r + 1.0 / 120.0;
    s = s * r + 1.0 / 24.0;
    s = s * r + 1.0 / 6.0;
    s = s * r + 0.5;
    s = s * r * r + r + 1.0;
    const V half = (k * 0.5 + kShift) - kShift;
    return s * power_of_two(half + kShift) * power_of_two((k - half) + kShift);
}

// log(x) = k ln 2 + log m, m in [sqrt(1/2), sqrt(2)): log m = 2 artanh z, z = (m - 1) / (m + 1), z^2 < 0.0295.
inline V logarithm(V x) {
    const Vi above = bits_of(x) - bits_of(broadcast(0.70710678118654752440));
    const Vi exponent = above >> 52;
    const V m = double_of(bits_of(x) - (exponent << 52));
    const V k = double_of(exponent + bits_of(broadcast(kShift))) - kShift;
    const V f = m - 1.0, z = f / (m + 1.0), z2 = z * z;
    V s = broadcast(1.0 / 23.0);
    s = s * z2 + 1.0 / 21.0;
    s = s * z2 + 1.0 / 19.0;
    s = s * z2 + 1.0 / 17.0;
    s = s * z2 + 1.0 / 15.0;
    s = s * z2 + 1.0 / 13.0;
    s = s * z2 + 1.0 / 11.0;
    s = s * z2 + 1.0 / 9.0;
    s = s * z2 + 1.0 / 7.0;
    s = s * z2 + 1.0 / 5.0;
    s = s * z2 + 1.0 / 3.0;
    // 2 z = f - z f exactly, and f is exact: the leading term carries no rounding of the division.
    const V tail = 2.0 * z * z2 * s - z * f;
    return k * 0.693147180369123816490 + (f + (tail + k * 1.90821492927058770002e-10));
}

template <int R, int W>
inline void tile(const double* coefficients, long row_step, const double* in, long in_step, int count, double* out,
                 long out_step) {
    V sum[R][W] = {};
    for (int k = 0; k < count; ++k) {
        V line[W];
        for (int w = 0; w < W; ++w) line[w] = load(in + k * in_step + w * kLanes);
        for (int r = 0; r < R; ++r) {
            const V c = broadcast(coefficients[r * row_step + k]);
            for (int w = 0; w < W; ++w) sum[r][w] += c * line[w];
        }
    }
    for (int r = 0; r < R; ++r)
        for (int w = 0; w < W; ++w) store(out + r * out_step + w * kLanes, sum[r][w]);
}

template <int R>
inline void tiles(const double* coefficients, long row_step, const double* in, long in_step, int count, double* out,
                  long out_step, int width) {
    int c = 0;
    for (; c + kWide * kLanes <= width; c += kWide * kLanes)
        tile<R, kWide>(coefficients, row_step, in + c, in_step, count, out + c, out_step);
    for (; c < width; c += kLanes) tile<R, 1>(coefficients, row_step, in + c, in_step, count, out + c, out_step);
}

inline int least(int a, int b) {
    return a < b ? a : b;
}
inline int most(int a, int b) {
    return a > b ? a : b;
}

// out[b] = sum over a in [a0, a1) of taps[a - b] in[a], b in [b0, b1); lines of `width` doubles, a multiple of kBlock,
// `step` apart. Offsets beyond the reach have the tap zero: the rows of a tile give the same bits as one by one.
void along_axis(const double* taps, int n, int reach, const double* in, int a0, int a1, double* out, int b0, int b1,
                int width, long step) {
    const double* centre = taps + n - 1;
    int b = b0;
    for (; b + 4 <= b1; b += 4) {
        const int first = most(a0, b - reach), last = least(a1, b + 4 + reach);
        tiles<4>(centre + first - b, -1, in + first * step, step, most(0, last - first), out + b * step, step, width);
    }
    for (; b < b1; ++b) {
        const int first = most(a0, b - reach), last = least(a1, b + 1 + reach);
        tiles<1>(centre + first - b, -1, in + first * step, step, most(0, last - first), out + b * step, step, width);
    }
}

// out[row] = in[row] K_z for `rows` lines of `width` doubles, of which nz count.
void along_line(const double* matrix, int nz, const double* in, double* out, int rows, int width) {
    int r = 0;
    for (; r + 4 <= rows; r += 4)
        tiles<4>(in + static_cast<long>(r) * width, width, matrix, width, nz, out + static_cast<long>(r) * width, width,
                 width);
    for (; r < rows; ++r)
        tiles<1>(in + static_cast<long>(r) * width, width, matrix, width, nz, out + static_cast<long>(r) * width, width,
                 width);
}

void forward_columns(const GaussianGrid& g, const Cover& cover, const double* in, const double* factor, double* out,
                     int c0, int c1, double* scratch) {
    const int nx = g.cells[0], columns = c1 - c0, width = (columns + kBlock - 1) / kBlock * kBlock;
    const long plane = static_cast<long>(g.cells[1]) * g.cells[2];
    double* result = scratch + static_cast<long>(nx) * kColumnBlock;
    for (int x = 0; x < nx; ++x) {
        double* line = scratch + static_cast<long>(x) * kColumnBlock;
        const double* from = in + x * plane + c0;
        if (factor) {
            const double* by = factor + x * plane + c0;
            for (int c = 0; c < columns; ++c) line[c] = by[c] * from[c];
        } else {
            for (int c = 0; c < columns; ++c) line[c] = from[c];
        }
        for (int c = columns; c < width; ++c) line[c] = 0.0;
        if (!factor)
            for (int c = 0; c < width; c += kLanes) store(line + c, exponential(load(line + c)));
    }
    along_axis(g.taps[0], nx, g.reach[0], scratch, 0, nx, result, cover.first, cover.last, width, kColumnBlock);
    for (int x = cover.first; x < cover.last; ++x)
        for (int c = 0; c < columns; ++c) out[x * plane + c0 + c] = result[static_cast<long>(x) * kColumnBlock + c];
}

void slab(const GaussianGrid& g, const Cover& cover, int x, const double* share, const double* ratio, double* kv,
          double* w, double* a, double* scratch) {
    const int ny = g.cells[1], nz = g.cells[2], width = padded_z(nz);
    const int y0 = cover.rows[2 * x], y1 = cover.rows[2 * x + 1], rows = y1 - y0;
    double* full = scratch;                                  // [ny]
    double* first = full + static_cast<long>(ny) * width;    // [ny], of which the rows of the cover are used
    double* second = first + static_cast<long>(ny) * width;  // [rows]
    for (int y = 0; y < ny; ++y) {
        double* line = full + static_cast<long>(y) * width;
        for (int z = 0; z < nz; ++z) line[z] = a[y * nz + z];
        for (int z = nz; z < width; ++z) line[z] = 0.0;
    }
    along_axis(g.taps[1], ny, g.reach[1], full, 0, ny, first, y0, y1, width, width);
    along_line(g.along_z, nz, first + static_cast<long>(y0) * width, second, rows, width);
    for (int r = 0; r < rows; ++r) {
        double* line = second + static_cast<long>(r) * width;
        const long at = static_cast<long>(y0 + r) * nz;
        if (ratio) {
            // In this order: share and ratio may both be near the ends of the range, their product beyond it.
            for (int z = 0; z < nz; ++z) line[z] = line[z] * ratio[at + z] * share[at + z];
        } else {
            for (int z = 0; z < nz; ++z) {
                const double k = line[z], q = share[at + z] / k;
                kv[at + z] = k;
                w[at + z] = line[z] = share[at + z] > 0 ? q : 0.0;
            }
        }
    }
    along_line(g.along_z, nz, second, first + static_cast<long>(y0) * width, rows, width);
    along_axis(g.taps[1], ny, g.reach[1], first, y0, y1, full, 0, ny, width, width);
    for (int y = 0; y < ny; ++y)
        for (int z = 0; z < nz; ++z) a[y * nz + z] = full[static_cast<long>(y) * width + z];
}

void backward_columns(const GaussianGrid& g, const Cover& cover, const double* a, const double* factor,
                      const double* minus, double floor, double* out, int c0, int c1, double* scratch) {
    const int nx = g.cells[0], columns = c1 - c0, width = (columns + kBlock - 1) / kBlock * kBlock;
    const long plane = static_cast<long>(g.cells[1]) * g.cells[2];
    double* result = scratch + static_cast<long>(nx) * kColumnBlock;
    for (int x = cover.first; x < cover.last; ++x) {
        double* line = scratch + static_cast<long>(x) * kColumnBlock;
        for (int c = 0; c < columns; ++c) line[c] = a[x * plane + c0 + c];
        for (int c = columns; c < width; ++c) line[c] = 0.0;
    }
    along_axis(g.taps[0], nx, g.reach[0], scratch, cover.first, cover.last, result, 0, nx, width, kColumnBlock);
    for (int x = 0; x < nx; ++x) {
        double* line = result + static_cast<long>(x) * kColumnBlock;
        const long at = x * plane + c0;
        if (factor) {
            for (int c = 0; c < columns; ++c) out[at + c] = minus[at + c] - line[c] * factor[at + c];
            continue;
        }
        for (int c = 0; c < width; c += kLanes) {
            const V d = load(line + c);  // a NaN must stay one
            store(line + c, select(d != d, d, logarithm(select(d > floor, d, broadcast(floor)))));
        }
        for (int c = 0; c < columns; ++c) out[at + c] = line[c];
    }
}

// Where line l of those with entries `step` apart begins.
inline long line_start(int l, int n, long step) {
    return l / step * step * n + l % step;
}

// kLanes lines in logarithms, entries kLogLines apart. The terms of output i are scaled by their largest, so that no
// distance underflows, and those below 2e-22 of it do not count. As the cost is convex in the distance, the first and
// the last entry that count for an output do not fall from one output to the next: what counts in the middle bounds
// what can count on either side.
struct LogLines {
    static constexpr double kNone = -__builtin_inf(), kLeast = -50.0;
    const double *cost, *from, *values;
    double *to, *means;

    V term(const double* far, int j) const { return load(from + static_cast<long>(j) * kLogLines) - far[j]; }

    // Outputs [i0, i1), for which entries [j0, j1) may count.
    void outputs(int i0, int i1, int j0, int j1) const {
        if (i0 >= i1) return;
        const int i = (i0 + i1) / 2;
        const double* far = cost - i;
        V best = broadcast(kNone);
        for (int j = j0; j < j1; ++j) {
            const V e = term(far, j);
            best = select(e > best, e, best);
        }
        const Mask some = best > kNone;
        const V scale = select(some, best, V{});
        int first = j0, end = j1;
        while (first < end && !any(term(far, first) - scale > kLeast)) ++first;
        while (end > first && !any(term(far, end - 1) - scale > kLeast)) --end;
        V sum{}, weighted{};
        for (int j = first; j < end; ++j) {
            const V e = term(far, j) - scale;
            const Mask counts = e > kLeast;
            if (!any(counts)) continue;
            const V t = select(counts, exponential(e), V{});
            sum += t;
            weighted += t * load(values + static_cast<long>(j) * kLogLines);
        }
        sum = select(some, sum, broadcast(1.0));
        store(to + static_cast<long>(i) * kLogLines, select(some, scale + logarithm(sum), best));
        store(means + static_cast<long>(i) * kLogLines, weighted / sum);
        outputs(i0, i, j0, end);
        outputs(i + 1, i1, first, j1);
    }
};

void log_lines(const double* cost, int n, long step, const double* in, double* out, double* value, int l0, int l1,
               double* scratch) {
    const long size = static_cast<long>(n) * kLogLines;
    double *from = scratch, *values = from + size, *to = values + size, *means = to + size;
    const int lines = l1 - l0, width = (lines + kLanes - 1) / kLanes * kLanes;
    for (int c = 0; c < width; ++c) {
        const long first = line_start(l0 + least(c, lines - 1), n, step);
        for (int j = 0; j < n; ++j) {
            from[j * kLogLines + c] = in[first + j * step];
            values[j * kLogLines + c] = value ? value[first + j * step] : 0.0;
        }
    }
    for (int c = 0; c < width; c += kLanes) {
        const LogLines group = {cost, from + c, values + c, to + c, means + c};
        group.outputs(0, n, 0, n);
    }
    for (int c = 0; c < lines; ++c) {
        const long first = line_start(l0 + c, n, step);
        for (int j = 0; j < n; ++j) {
            out[first + j * step] = to[j * kLogLines + c];
            if (value) value[first + j * step] = means[j * kLogLines + c];
        }
    }
}

// The last, shorter piece goes through the same instructions: results do not depend on where an entry stands.
template <class F>
inline void for_all(const double* in, double* out, int n, F&& f) {
    int c = 0;
    for (; c + kLanes <= n; c += kLanes) store(out + c, f(load(in + c)));
    if (c == n) return;
    V last = broadcast(1.0);
    for (int l = 0; c + l < n; ++l) last[l] = in[c + l];
    last = f(last);
    for (int l = 0; c + l < n; ++l) out[c + l] = last[l];
}

void exp_all(const double* in, double* out, int n) {
    for_all(in, out, n, [](V v) { return exponential(v); });
}
void log_all(const double* in, double* out, int n) {
    for_all(in, out, n, [](V v) { return logarithm(v); });
}

}  // namespace

const BarycenterKernels& DQA_KERNEL_TABLE() {
    static const BarycenterKernels table = {forward_columns, slab, backward_columns, log_lines, exp_all, log_all};
    return table;
}

}  // namespace dqa
