// SPDX-License-Identifier: MIT
#include "linalg/sparse.hpp"

#include <algorithm>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include "grid/error.hpp"
#include "linalg/blas_memory.hpp"

#if defined(DQA_HAVE_CHOLMOD)
#include <cholmod.h>
#endif
#if defined(_OPENMP)
#include <omp.h>
#endif
#if defined(DQA_HAVE_UMFPACK)
#include <umfpack.h>
#endif

namespace dqa {
namespace {

#if !defined(DQA_HAVE_CHOLMOD) || !defined(DQA_HAVE_UMFPACK)
using EigenSparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

EigenSparse to_eigen(const SymmetricMatrix& a) {
    EigenSparse lower = Eigen::Map<const EigenSparse>(a.n, a.n, static_cast<Eigen::Index>(a.value.size()),
                                                      a.start.data(), a.row.data(), a.value.data());
    return lower;
}
#endif

// b - A x
std::vector<double> residual_of(const SymmetricMatrix& a, const std::vector<double>& b, const std::vector<double>& x) {
    std::vector<double> r(b);
    for (std::size_t j = 0; j < x.size(); ++j)
        for (int k = a.start[j]; k < a.start[j + 1]; ++k) {
            const std::size_t i = static_cast<std::size_t>(a.row[static_cast<std::size_t>(k)]);
            r[i] -= a.value[static_cast<std::size_t>(k)] * x[j];
            if (i != j) r[j] -= a.value[static_cast<std::size_t>(k)] * x[i];
        }
    return r;
}

// Improves x, a solution of A x = b to rounding, as long as the residual falls; solve(r) replaces r by A^-1 r.
template <class Solve>
void refine(const SymmetricMatrix& a, const std::vector<double>& b, std::vector<double>& x, const Solve& solve) {
    const auto squared = [](const std::vector<double>& r) {
        double sum = 0.0;
        for (const double value : r) sum += value * value;
        return sum;
    };
    std::vector<double> r = residual_of(a, b, x);
    for (int round = 0; round < 3; ++round) {
        const double before = squared(r);
        solve(r);
        std::vector<double> better(x);
        for (std::size_t i = 0; i < x.size(); ++i) better[i] += r[i];
        r = residual_of(a, b, better);
        if (!(squared(r) < before)) return;
        x.swap(better);
    }
}

#if defined(DQA_HAVE_CHOLMOD)

// CHOLMOD opens parallel regions of four threads of its own, whatever the number of threads of the calling object, and
// for loops so short that they take longer than the factorisation. While this lives, the calling thread opens none.
class NoParallelRegions {
public:
#if defined(_OPENMP)
    NoParallelRegions() : levels_(omp_get_max_active_levels()) {
        omp_set_max_active_levels(0);
    }
    ~NoParallelRegions() {
        omp_set_max_active_levels(levels_);
    }
    NoParallelRegions(const NoParallelRegions&) = delete;
    NoParallelRegions& operator=(const NoParallelRegions&) = delete;

private:
    int levels_;
#endif
};

// CHOLMOD's context: silent, on the calling thread alone, and freed with the scope.
class Context {
public:
    Context() {  // std::bad_alloc
        cholmod_start(&c);
        c.print = 0;
        c.error_handler = nullptr;
        // By itself CHOLMOD would also try METIS, which raises signals where it fails and reseeds the host's rand().
        c.nmethods = 1;
        c.method[0].ordering = CHOLMOD_AMD;
    }
    ~Context() { cholmod_finish(&c); }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    cholmod_common c;

private:
    BlasCall room_;
    NoParallelRegions serial_;
};

cholmod_sparse view_of(const SymmetricMatrix& a) {
    cholmod_sparse s{};
    s.nrow = s.ncol = static_cast<std::size_t>(a.n);
    s.nzmax = a.value.size();
    s.p = const_cast<int*>(a.start.data());  // CHOLMOD's interface is not const-correct; it only reads
    s.i = const_cast<int*>(a.row.data());
    s.x = const_cast<double*>(a.value.data());
    s.stype = -1;
    s.itype = CHOLMOD_INT;
    s.xtype = CHOLMOD_REAL;
    s.dtype = CHOLMOD_DOUBLE;
    s.sorted = 1;
    s.packed = 1;
    return s;
}

// A factor that is freed with the scope, whatever leaves it: an allocation of ours may fail while it lives.
class Factor {
public:
    Factor(cholmod_factor* l, cholmod_common& c) : l_(l), c_(c) {}
    ~Factor() {
        if (l_) cholmod_free_factor(&l_, &c_);
    }
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;
    cholmod_factor* get() const { return l_; }

private:
    cholmod_factor* l_;
    cholmod_common& c_;
};

void check_memory(const cholmod_common& c) {
    if (c.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
}

#endif

}  // namespace

#if defined(DQA_HAVE_CHOLMOD)

CholeskyFactor factorise(const SymmetricMatrix& matrix, const std::vector<int>& order) {
    Context context;
    cholmod_common& c = context.c;
    c.supernodal = CHOLMOD_SUPERNODAL;
    c.method[0].ordering = CHOLMOD_GIVEN;
    c.postorder = 1;
    cholmod_sparse a = view_of(matrix);
    std::vector<int> given(order);
    const Factor owner(cholmod_analyze_p(&a, given.data(), nullptr, 0, &c), c);
    cholmod_factor* l = owner.get();
    check_memory(c);
    if (!l) fail(Status::ERROR_INTERNAL, "CHOLMOD analysis failed with status %d", c.status);
    cholmod_factorize(&a, l, &c);
    check_memory(c);
    if (c.status != CHOLMOD_OK || l->minor < l->n || !l->is_super)
        fail(Status::ERROR_INTERNAL, "the preconditioner's matrix is not positive definite (CHOLMOD status %d)",
             c.status);
    CholeskyFactor out;
    out.n = matrix.n;
    const int* perm = static_cast<const int*>(l->Perm);
    out.permutation.assign(perm, perm + matrix.n);
    const int *super = static_cast<const int*>(l->super), *pi = static_cast<const int*>(l->pi),
              *px = static_cast<const int*>(l->px), *rows = static_cast<const int*>(l->s);
    const double* x = static_cast<const double*>(l->x);
    for (std::size_t s = 0; s < l->nsuper; ++s) {
        Supernode node;
        node.first = super[s];
        node.columns = super[s + 1] - super[s];
        node.rows.assign(rows + pi[s], rows + pi[s + 1]);
        node.values.assign(x + px[s], x + px[s] + static_cast<long>(node.rows.size()) * node.columns);
        out.entries += static_cast<long>(node.rows.size()) * node.columns - node.columns * (node.columns - 1) / 2;
        out.supernodes.push_back(std::move(node));
    }
    return out;
}

bool solve_positive(const SymmetricMatrix& matrix, std::vector<double>& x) {
    Context context;
    cholmod_common& c = context.c;
    c.final_ll = 1;  // small matrices are not factorised by supernodes but as L D L^T, which lets negative pivots pass
    cholmod_sparse a = view_of(matrix);
    const Factor owner(cholmod_analyze(&a, &c), c);
    cholmod_factor* l = owner.get();
    check_memory(c);
    if (!l) return false;
    cholmod_factorize(&a, l, &c);
    const bool good = c.status == CHOLMOD_OK && l->minor >= l->n;
    if (good) {
        const auto solve = [&](std::vector<double>& field) {
            cholmod_dense b{};
            b.nrow = static_cast<std::size_t>(matrix.n), b.ncol = 1, b.nzmax = b.nrow, b.d = b.nrow;
            b.x = field.data();
            b.xtype = CHOLMOD_REAL, b.dtype = CHOLMOD_DOUBLE;
            cholmod_dense* solution = cholmod_solve(CHOLMOD_A, l, &b, &c);
            if (!solution) return;
            const double* values = static_cast<const double*>(solution->x);
            std::copy(values, values + matrix.n, field.begin());
            cholmod_free_dense(&solution, &c);
        };
        const std::vector<double> right(x);
        solve(x);
        refine(matrix, right, x, solve);
    }
    check_memory(c);
    return good;
}

#else

CholeskyFactor factorise(const SymmetricMatrix& matrix, const std::vector<int>& order) {
    // Eigen factorises one column at a time; columns of equal pattern are merged into supernodes afterwards.
    const int n = matrix.n;
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> p(n);
    for (int k = 0; k < n; ++k) p.indices()(order[static_cast<std::size_t>(k)]) = k;
    const EigenSparse lower = to_eigen(matrix);
    EigenSparse permuted(n, n);
    permuted.selfadjointView<Eigen::Lower>() = lower.selfadjointView<Eigen::Lower>().twistedBy(p);
    const Eigen::SimplicialLLT<EigenSparse, Eigen::Lower, Eigen::NaturalOrdering<int>> llt(permuted);
    if (llt.info() != Eigen::Success)
        fail(Status::ERROR_INTERNAL, "the preconditioner's matrix is not positive definite");
    const EigenSparse l = llt.matrixL();
    CholeskyFactor out;
    out.n = n;
    out.permutation = order;
    const int *start = l.outerIndexPtr(), *row = l.innerIndexPtr();
    const double* value = l.valuePtr();
    for (int j = 0; j < n;) {
        int end = j + 1;
        // Column end joins if its pattern is that of column end - 1 without its diagonal.
        while (end < n && start[end + 1] - start[end] == start[end] - start[end - 1] - 1 &&
               row[start[end - 1] + 1] == end &&
               std::equal(row + start[end], row + start[end + 1], row + start[end - 1] + 1))
            ++end;
        Supernode node;
        node.first = j;
        node.columns = end - j;
        node.rows.assign(row + start[j], row + start[j + 1]);
        node.values.assign(node.rows.size() * static_cast<std::size_t>(node.columns), 0.0);
        for (int k = j; k < end; ++k)
            for (int i = start[k]; i < start[k + 1]; ++i)
                node.values[static_cast<std::size_t>(k - j) * node.rows.size() +
                            static_cast<std::size_t>(k - j + i - start[k])] = value[i];
        out.entries += start[end] - start[j];
        out.supernodes.push_back(std::move(node));
        j = end;
    }
    return out;
}

bool solve_positive(const SymmetricMatrix& matrix, std::vector<double>& x) {
    const Eigen::SimplicialLLT<EigenSparse> llt(to_eigen(matrix));
    if (llt.info() != Eigen::Success) return false;
    const auto solve = [&](std::vector<double>& field) {
        Eigen::Map<Eigen::VectorXd> map(field.data(), matrix.n);
        map = llt.solve(Eigen::VectorXd(map));
    };
    const std::vector<double> right(x);
    solve(x);
    refine(matrix, right, x, solve);
    return true;
}

#endif

#if defined(DQA_HAVE_UMFPACK)

bool solve_indefinite(const SymmetricMatrix& matrix, std::vector<double>& x) {
    // Both triangles by columns; of a symmetric matrix rows and columns are the same.
    const int n = matrix.n;
    std::vector<int> start(static_cast<std::size_t>(n) + 1, 0);
    for (int j = 0; j < n; ++j)
        for (int k = matrix.start[static_cast<std::size_t>(j)]; k < matrix.start[static_cast<std::size_t>(j) + 1];
             ++k) {
            const int i = matrix.row[static_cast<std::size_t>(k)];
            ++start[static_cast<std::size_t>(j) + 1];
            if (i != j) ++start[static_cast<std::size_t>(i) + 1];
        }
    for (int j = 0; j < n; ++j) start[static_cast<std::size_t>(j) + 1] += start[static_cast<std::size_t>(j)];
    std::vector<int> fill(start.begin(), start.end() - 1), row(static_cast<std::size_t>(start.back()));
    std::vector<double> value(row.size());
    // Columns in order: upper entries (i < j) of column j come from lower columns i, already written ascending.
    for (int j = 0; j < n; ++j)
        for (int k = matrix.start[static_cast<std::size_t>(j)]; k < matrix.start[static_cast<std::size_t>(j) + 1];
             ++k) {
            const int i = matrix.row[static_cast<std::size_t>(k)];
            std::size_t at = static_cast<std::size_t>(fill[static_cast<std::size_t>(j)]++);
            row[at] = i, value[at] = matrix.value[static_cast<std::size_t>(k)];
            if (i == j) continue;
            at = static_cast<std::size_t>(fill[static_cast<std::size_t>(i)]++);
            row[at] = j, value[at] = matrix.value[static_cast<std::size_t>(k)];
        }
    for (int j = 0; j < n; ++j) {  // UMFPACK wants ascending rows
        std::vector<std::pair<int, double>> column;
        for (int k = start[static_cast<std::size_t>(j)]; k < start[static_cast<std::size_t>(j) + 1]; ++k)
            column.emplace_back(row[static_cast<std::size_t>(k)], value[static_cast<std::size_t>(k)]);
        std::sort(column.begin(), column.end());
        for (std::size_t k = 0; k < column.size(); ++k) {
            row[static_cast<std::size_t>(start[static_cast<std::size_t>(j)]) + k] = column[k].first;
            value[static_cast<std::size_t>(start[static_cast<std::size_t>(j)]) + k] = column[k].second;
        }
    }
    const std::vector<double> b(x);  // before anything lives that an exception would leave behind
    const BlasCall room;
    void *symbolic = nullptr, *numeric = nullptr;
    int status = umfpack_di_symbolic(n, n, start.data(), row.data(), value.data(), &symbolic, nullptr, nullptr);
    if (status == UMFPACK_OK)
        status = umfpack_di_numeric(start.data(), row.data(), value.data(), symbolic, &numeric, nullptr, nullptr);
    umfpack_di_free_symbolic(&symbolic);
    bool good = status == UMFPACK_OK;
    if (good) {
        good = umfpack_di_solve(UMFPACK_A, start.data(), row.data(), value.data(), x.data(), b.data(), numeric, nullptr,
                                nullptr) == UMFPACK_OK;
    }
    umfpack_di_free_numeric(&numeric);
    if (status == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
    return good;
}

#else

bool solve_indefinite(const SymmetricMatrix& matrix, std::vector<double>& x) {
    const EigenSparse lower = to_eigen(matrix);
    const EigenSparse full = lower.selfadjointView<Eigen::Lower>();
    Eigen::SparseLU<EigenSparse> lu;
    lu.compute(full);
    if (lu.info() != Eigen::Success) return false;
    Eigen::Map<Eigen::VectorXd> map(x.data(), matrix.n);
    map = lu.solve(Eigen::VectorXd(map));
    return lu.info() == Eigen::Success;
}

#endif

SymmetricMatrix matrix_from_columns(std::vector<std::vector<std::pair<int, double>>>& columns) {
    SymmetricMatrix m;
    m.n = static_cast<int>(columns.size());
    m.start.push_back(0);
    for (auto& column : columns) {
        std::sort(column.begin(), column.end());
        for (const auto& [row, value] : column) m.row.push_back(row), m.value.push_back(value);
        m.start.push_back(static_cast<int>(m.row.size()));
    }
    return m;
}

const char* direct_solver_name() {
#if defined(DQA_HAVE_CHOLMOD) && defined(DQA_HAVE_UMFPACK)
    return "cholmod umfpack";
#elif defined(DQA_HAVE_CHOLMOD)
    return "cholmod";
#else
    return "eigen";
#endif
}

}  // namespace dqa
