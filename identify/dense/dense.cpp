// The door to OpenBLAS, and Eigen where it is not there.

#include "identify/dense/dense.h"

#include <dlfcn.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// LAPACK's Fortran interface; the lengths of texts come last and are ignored.
using Potrf = void (*)(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
using Potri = void (*)(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
using Trsm = void (*)(const char* side, const char* uplo, const char* transposed, const char* diagonal, const int* m,
                      const int* n, const double* alpha, const double* a, const int* lda, double* b, const int* ldb,
                      std::size_t, std::size_t, std::size_t, std::size_t);
struct Lapack {
  Potrf potrf = nullptr;
  Potri potri = nullptr;
  Trsm trsm = nullptr;
  bool is_there() const { return potrf != nullptr && potri != nullptr && trsm != nullptr; }
};

Lapack load() {
  Lapack lapack;
  void* library = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return lapack;
  // More than one thread spins between calls and changes the order of sums.
  if (auto* one = reinterpret_cast<void (*)(int)>(dlsym(library, "openblas_set_num_threads"))) one(1);
  lapack.potrf = reinterpret_cast<Potrf>(dlsym(library, "dpotrf_"));
  lapack.potri = reinterpret_cast<Potri>(dlsym(library, "dpotri_"));
  lapack.trsm = reinterpret_cast<Trsm>(dlsym(library, "dtrsm_"));
  return lapack;
}

// Below this size the library's start-up costs more than it saves.
constexpr Index large = 128;

const Lapack& lapack() {
  static const Lapack loaded = load();
  return loaded;
}

void solve(const MatrixXd& l, Eigen::Ref<MatrixXd> b, bool transposed) {
  if (b.size() == 0) return;  // Eigen would bind a reference to the first of no numbers
  if (b.cols() >= 16 && l.rows() >= large && lapack().is_there()) {
    const int m = static_cast<int>(b.rows()), n = static_cast<int>(b.cols()), lda = static_cast<int>(l.rows());
    const int ldb = static_cast<int>(b.outerStride());
    const double one = 1;
    lapack().trsm("L", "L", transposed ? "T" : "N", "N", &m, &n, &one, l.data(), &lda, b.data(), &ldb, 1, 1, 1, 1);
    return;
  }
  if (transposed) {
    l.triangularView<Eigen::Lower>().transpose().solveInPlace(b);
  } else {
    l.triangularView<Eigen::Lower>().solveInPlace(b);
  }
}

}  // namespace

bool factorise(MatrixXd& a) {
  const int n = static_cast<int>(a.rows());
  if (n >= large && lapack().is_there()) {
    // A number that is not finite would run through LAPACK's factor unseen.
    for (Index j = 0; j < n; ++j) {
      if (!std::isfinite(a.col(j).tail(n - j).sum())) return false;
    }
    int info = 0;
    lapack().potrf("L", &n, a.data(), &n, &info, 1);
    return info == 0;
  }
  // In place: the factor stands in the lower triangle of `a`.
  const Eigen::LLT<Eigen::Ref<MatrixXd>, Eigen::Lower> factor(a);
  return factor.info() == Eigen::Success && a.diagonal().allFinite() && a.diagonal().minCoeff() > 0;
}

void invert_factored(MatrixXd& l) {
  const int n = static_cast<int>(l.rows());
  if (n >= large && lapack().is_there()) {
    int info = 0;
    lapack().potri("L", &n, l.data(), &n, &info, 1);
    return;
  }
  MatrixXd inverse = MatrixXd::Identity(n, n);
  l.triangularView<Eigen::Lower>().solveInPlace(inverse);
  l.setZero();
  l.selfadjointView<Eigen::Lower>().rankUpdate(inverse.transpose());
}

void solve_lower(const MatrixXd& l, Eigen::Ref<MatrixXd> b) { solve(l, b, false); }
void solve_lower_transposed(const MatrixXd& l, Eigen::Ref<MatrixXd> b) { solve(l, b, true); }

void mirror_lower(MatrixXd& a) {
  // In blocks, so that both sides stay in cache.
  constexpr Index block = 64;
  const Index n = a.rows();
  for (Index i = 0; i < n; i += block) {
    const Index rows = std::min(block, n - i);
    for (Index j = 0; j < i; j += block) a.block(j, i, block, rows) = a.block(i, j, rows, block).transpose();
    auto square = a.block(i, i, rows, rows);
    for (Index c = 1; c < rows; ++c) {
      for (Index r = 0; r < c; ++r) square(r, c) = square(c, r);
    }
  }
}

}  // namespace plantloop::identify
