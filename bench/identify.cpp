// bench_identify FOLDER: the costly steps of identification against what others do, in interleaved pairs.
//
//   gp_step       log likelihood and gradient of a Gaussian process, N = 1000, D = 8, against scikit-learn's; left out
//                 where python3 has no sklearn
//   cholesky      of a 2000 x 2000 matrix, against OpenBLAS called directly; left out where that is not installed
//   lm_iteration  of an 8-10-1 network on 2000 samples, against a loop written for just that network with Eigen
//
// Processor times, as other programs may run at the same time. Exit status 1 when two sides compute different numbers;
// times decide nothing. With PLANTLOOP_BENCH_QUICK set, one short pair each.

#include <dlfcn.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "identify/dense/dense.h"
#include "identify/gp/gaussian_process.h"
#include "identify/mlp/problems.h"
#include "identify/random.h"

namespace plantloop::bench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Seconds of one call: the least of several.
double time_of(const std::function<void()>& work, int calls) {
  double least = HUGE_VAL;
  for (int i = 0; i < calls; ++i) {
    const double began = processor_time();
    work();
    least = std::min(least, processor_time() - began);
  }
  return least;
}

MatrixXd random_matrix(Index rows, Index columns, std::uint64_t seed) {
  identify::Random random(seed);
  MatrixXd m(rows, columns);
  for (double& x : m.reshaped()) x = random.uniform(-1, 1);
  return m;
}

void tell(const char* name, double ours, double theirs, const char* whose, const char* goal, bool agree) {
  fmt::print("{:<14} {:10.5f} s {:10.5f} s {:8.2f}  {}, {}{}\n", name, ours, theirs, ours / theirs, whose, goal,
             agree ? "" : "  VALUES DIFFER");
  std::fflush(stdout);
}

bool close(double a, double b, double relative) {
  return std::fabs(a - b) <= relative * (std::fabs(a) + std::fabs(b) + 1e-6);
}

// --- The Gaussian process.

bool gp_step(const std::string& folder, int calls) {
  const Index n = calls == 1 ? 200 : 1000, d = 8;
  const MatrixXd x = random_matrix(n, d, 1) * 2;
  const VectorXd y = (x * VectorXd::LinSpaced(d, 0.2, 1)).array().sin() + 0.1 * random_matrix(n, 1, 2).col(0).array();
  const auto covariance = identify::find_covariance("se_ard");
  identify::Hyperparameters at{VectorXd::Constant(d + 1, 0.3), 0.02};
  at.theta[d] = 1.5;
  identify::Likelihood found;
  const double ours =
      time_of([&] { found = identify::log_likelihood(*covariance, identify::MeanFunction::zero, at, x, y); }, calls);

  const std::string points = folder + "/gp_step.txt", answer = folder + "/gp_step.answer";
  std::ofstream file(points);
  file << fmt::format("{} {} {:.17g} {:.17g} {:.17g} {}\n", n, d, at.theta[0], at.theta[d], at.v0, calls);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < d; ++j) file << fmt::format("{:.17g} ", x(i, j));
    file << fmt::format("{:.17g}\n", y[i]);
  }
  file.close();
  const std::string command =
      fmt::format("OPENBLAS_NUM_THREADS=1 /usr/bin/python3 '{}/sklearn_gp.py' '{}' > '{}' 2> /dev/null",
                  PLANTLOOP_BENCH_SOURCES, points, answer);
  if (std::system(command.c_str()) != 0) {
    fmt::print("{:<14} {:10.5f} s            left out: /usr/bin/python3 has no sklearn\n", "gp_step", ours);
    return true;
  }
  std::ifstream back(answer);
  const std::vector<double> numbers{std::istream_iterator<double>(back), {}};
  if (numbers.size() != static_cast<std::size_t>(d + 4)) return false;
  bool agree = close(numbers[1], found.value, 1e-9);
  for (Index i = 0; i < d + 2; ++i) {
    agree = agree && close(numbers[static_cast<std::size_t>(i + 2)], found.gradient[i], 1e-7);
  }
  tell("gp_step", ours, numbers[0], "scikit-learn", "goal 0.1, at most 0.2", agree);
  return agree;
}

// --- The Cholesky factor.

bool cholesky(int calls) {
  const Index n = calls == 1 ? 200 : 2000;
  const MatrixXd half = random_matrix(n, n, 3);
  MatrixXd a = MatrixXd::Identity(n, n) * static_cast<double>(n);
  a.selfadjointView<Eigen::Lower>().rankUpdate(half);
  void* library = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL);
  using Potrf = void (*)(const char*, const int*, double*, const int*, int*, std::size_t);
  const auto potrf = library != nullptr ? reinterpret_cast<Potrf>(dlsym(library, "dpotrf_")) : nullptr;
  MatrixXd one, two;
  double ours = HUGE_VAL, theirs = HUGE_VAL;
  for (int i = 0; i < calls; ++i) {
    one = a;
    two = a;
    ours = std::min(ours, time_of([&] { identify::factorise(one); }, 1));
    if (potrf == nullptr) continue;
    const int size = static_cast<int>(n);
    int info = 0;
    theirs = std::min(theirs, time_of([&] { potrf("L", &size, two.data(), &size, &info, 1); }, 1));
  }
  if (potrf == nullptr) {
    fmt::print("{:<14} {:10.5f} s            left out: there is no libopenblas.so.0\n", "cholesky", ours);
    return true;
  }
  const bool agree = MatrixXd((one - two).triangularView<Eigen::Lower>()).cwiseAbs().maxCoeff() < 1e-9;
  tell("cholesky", ours, theirs, "OpenBLAS", "at most 1.3", agree);
  return agree;
}

// --- One iteration of Levenberg-Marquardt.

// Written for one hidden layer of tanh and one output, the samples as columns.
struct ByHand {
  MatrixXd x;  // inputs x samples
  VectorXd y;
  MatrixXd w1;  // hidden x (inputs + 1)
  VectorXd w2;  // hidden + 1

  double sse() const {
    const MatrixXd h =
        ((w1.leftCols(x.rows()) * x).colwise() + w1.col(x.rows())).unaryExpr([](double s) { return std::tanh(s); });
    return (y - h.transpose() * w2.head(h.rows()) - VectorXd::Constant(y.size(), w2[h.rows()])).squaredNorm();
  }
  // A step from theta = [w2, w1 row by row]; the sum of squares after it.
  double iterate(double lambda) {
    const Index n = x.cols(), d = x.rows(), hidden = w1.rows(), p = hidden + 1 + hidden * (d + 1);
    const MatrixXd h = ((w1.leftCols(d) * x).colwise() + w1.col(d)).unaryExpr([](double s) { return std::tanh(s); });
    const VectorXd e = y - h.transpose() * w2.head(hidden) - VectorXd::Constant(n, w2[hidden]);
    MatrixXd j(n, p);
    j.leftCols(hidden) = h.transpose();
    j.col(hidden).setOnes();
    for (Index i = 0; i < hidden; ++i) {
      const VectorXd slope = w2[i] * (1 - h.row(i).array().square()).transpose();
      const Index at = hidden + 1 + i * (d + 1);
      for (Index k = 0; k < d; ++k) j.col(at + k) = slope.cwiseProduct(x.row(k).transpose());
      j.col(at + d) = slope;
    }
    MatrixXd r = MatrixXd::Zero(p, p);
    r.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
    r.diagonal().array() += lambda;
    const VectorXd step = Eigen::LDLT<MatrixXd>(r.selfadjointView<Eigen::Lower>()).solve(j.transpose() * e);
    w2 += step.head(hidden + 1);
    for (Index i = 0; i < hidden; ++i) w1.row(i) += step.segment(hidden + 1 + i * (d + 1), d + 1).transpose();
    return sse();
  }
};

bool lm_iteration(int calls) {
  const Index n = 2000, d = 8, hidden = 10;
  const MatrixXd x = random_matrix(n, d, 4);
  const VectorXd y = (x * VectorXd::LinSpaced(d, 0.1, 0.9)).array().sin();
  identify::Network network = identify::make_network(d, {static_cast<int>(hidden)}, 1, identify::Activation::tanh);
  identify::Random random(5);
  identify::randomise(network, 0.5, random);
  const identify::StaticTraining training(network, x, y);
  const VectorXd start = network.theta();
  ByHand hand{x.transpose(), y, network.layers[0].w, network.layers[1].w.transpose()};
  const ByHand at_start = hand;

  double ours = HUGE_VAL, theirs = HUGE_VAL, our_sse = 0, their_sse = 0;
  for (int i = 0; i < calls; ++i) {
    ours = std::min(ours, time_of(
                              [&] {
                                MatrixXd r;
                                VectorXd g;
                                training.normal(start, r, g);
                                r.diagonal().array() += 1;
                                our_sse = training.sse(start + Eigen::LDLT<MatrixXd>(r).solve(g));
                              },
                              1));
    hand = at_start;
    theirs = std::min(theirs, time_of([&] { their_sse = hand.iterate(1); }, 1));
  }
  const bool agree = close(our_sse, their_sse, 1e-9);
  tell("lm_iteration", ours, theirs, "by hand with Eigen", "at most 1.5", agree);
  return agree;
}

int run(const std::string& folder) {
  const int calls = std::getenv("PLANTLOOP_BENCH_QUICK") != nullptr ? 1 : 7;
  fmt::print("{:<14} {:>12} {:>12} {:>8}\n", "least of runs", "plantloop", "other", "ratio");
  const bool likelihoods = gp_step(folder, calls);
  const bool factors = cholesky(calls);
  const bool iterations = lm_iteration(calls == 1 ? 1 : 20);
  return likelihoods && factors && iterations ? 0 : 1;
}

}  // namespace
}  // namespace plantloop::bench

int main(int argc, char** argv) { return plantloop::bench::run(argc > 1 ? argv[1] : "."); }
