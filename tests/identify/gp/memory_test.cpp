// How much memory fits need: what grows with the square of the samples must leave room for 4000 of them in 4 GiB.

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>

#include "identify/data/excitation.h"
#include "identify/gp/covariance.h"
#include "identify/gp/fit_sparse.h"
#include "identify/gp/gaussian_process.h"
#include "identify/linear/regression_model.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Bytes by which the peak of a process of its own rises while `work` runs; below 0 when it does not end well.
template <typename Work>
double peak_of(const Work& work) {
  int ends[2];
  if (pipe(ends) != 0) return -1;
  malloc_trim(0);  // what earlier tests gave back would be used again unseen
  const pid_t child = fork();
  if (child == 0) {
    const auto peak = [] {
      rusage usage{};
      getrusage(RUSAGE_SELF, &usage);
      return static_cast<double>(usage.ru_maxrss) * 1024;
    };
    const double before = peak();
    work();
    const double grown = peak() - before;
    const bool told = write(ends[1], &grown, sizeof grown) == sizeof grown;
    _exit(told ? 0 : 1);
  }
  double grown = -1;
  int status = -1;
  const bool told = read(ends[0], &grown, sizeof grown) == sizeof grown;
  waitpid(child, &status, 0);
  close(ends[0]);
  close(ends[1]);
  return told && status == 0 ? grown : -1;
}

bool is_measured() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;  // sanitizers need memory of their own
#else
  return true;
#endif
}

TEST(Memory, OfALikelihoodWithGradientIsAFewMatricesOfCovariances) {
  if (!is_measured()) GTEST_SKIP() << "sanitizers need memory of their own";
  constexpr Index n = 1500;
  const double grown = peak_of([n] {
    Random random(1);
    MatrixXd x(n, 8);
    VectorXd y(n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < 8; ++j) x(i, j) = random.normal();
      y[i] = std::sin(x(i, 0)) + 0.1 * random.normal();
    }
    const auto covariance = find_covariance("se_ard");
    Hyperparameters at{VectorXd::Ones(9), 0.01};
    if (!std::isfinite(log_likelihood(*covariance, MeanFunction::zero, at, x, y).value)) _exit(2);
  });
  const double matrix = 8.0 * n * n;
  EXPECT_GT(grown, matrix);       // something was measured
  EXPECT_LT(grown, 10 * matrix);  // of 4000 points: 1.3 GB
}

TEST(Memory, OfASparseProcessOfTwentyThousandSamplesIsAFewOfItsCovariances) {
  if (!is_measured()) GTEST_SKIP() << "sanitizers need memory of their own";
  constexpr Index n = 20000;
  constexpr int m = 100;
  const double grown = peak_of([n] {
    Random random(1);
    MatrixXd x(n, 8);
    VectorXd y(n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < 8; ++j) x(i, j) = random.normal();
      y[i] = std::sin(x(i, 0)) + 0.1 * random.normal();
    }
    GpOptions options;
    options.starts = 1;
    options.max_iterations = 2;
    SparseOptions sparse;
    sparse.inducing = m;
    sparse.refined = 1;
    if (!std::isfinite(fit_sparse(x, y, options, sparse).report.reached)) _exit(2);
  });
  const double matrix = 8.0 * n * m;
  EXPECT_GT(grown, matrix);       // something was measured
  EXPECT_LT(grown, 12 * matrix);  // 192 MB
}

TEST(Memory, OfAPolynomialOfTwentyThousandSamplesIsThatOfItsRegressors) {
  if (!is_measured()) GTEST_SKIP() << "sanitizers need memory of their own";
  const double grown = peak_of([] {
    const Index n = 20000;
    const VectorXd u = staircase(n, 5, 5, -1, 1, 1);
    VectorXd y = VectorXd::Zero(n);
    for (Index k = 1; k < n; ++k) y[k] = 0.8 * y[k - 1] + 0.2 * u[k - 1] - 0.05 * std::pow(y[k - 1], 3);
    const DataSet data = make_data_set(u, y, 1, {{"u", ""}}, {{"y", ""}});
    const RegressorSet set = polynomial(parse_regressors("y(k-1..3), u(k-1..3)", data), 3);
    const RegressionModel model = fit_selected(data, set, {.most_terms = 6, .iterations = 5});
    if (model.theta.size() < 3) _exit(2);
  });
  EXPECT_GT(grown, 0);
  EXPECT_LT(grown, 400e6);
}

}  // namespace
}  // namespace plantloop::identify
