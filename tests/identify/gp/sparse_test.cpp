// The sparse approximation against the full process.

#include "identify/gp/sparse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <set>

#include "identify/error.h"
#include "identify/gp/gaussian_process.h"
#include "identify/gp/inducing.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Data {
  MatrixXd x = random_points(300, 2, 91);
  VectorXd y = first_order_targets(x, 0.05, 92);
  Hyperparameters at{random_positive(3, 93), 0.0025};
  std::shared_ptr<const Covariance> form = find_covariance("se_ard");
};

TEST(Sparse, WithAllInputsInducingIsTheFullProcess) {
  const Data data;
  const MatrixXd x = data.x.topRows(60);
  const VectorXd y = data.y.head(60);
  const GaussianProcess full(data.form, MeanFunction::zero, data.at, x, y);
  const SparseGaussianProcess sparse(SparseMethod::fitc, data.form, MeanFunction::zero, data.at, x, y, x);
  const MatrixXd probe = random_points(30, 2, 94);
  EXPECT_LT((full.predict(probe).mean - sparse.predict(probe).mean).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((full.predict(probe).variance - sparse.predict(probe).variance).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(full.log_likelihood(), sparse.log_likelihood(), 1e-5);
}

// By explicit inverses: log N(y; 0, Q + G) and the mean K_*u (K_uu + K_uf G^-1 K_fu)^-1 K_uf G^-1 y.
TEST(Sparse, AgreesWithTheExplicitFormulas) {
  const Data data;
  const MatrixXd u = data.x(spread_subset(data.x, 12), Eigen::all);
  const SparseGaussianProcess sparse(SparseMethod::fitc, data.form, MeanFunction::zero, data.at, data.x, data.y, u);
  MatrixXd kuu = data.form->between(data.at.theta, u, u);
  kuu.diagonal().array() += 1e-10 * kuu.diagonal().mean();
  const MatrixXd kuf = data.form->between(data.at.theta, u, data.x);
  const MatrixXd q = kuf.transpose() * kuu.inverse() * kuf;
  const VectorXd g = (data.form->at(data.at.theta, data.x) - q.diagonal()).array() + data.at.v0;
  const MatrixXd c = q + MatrixXd(g.asDiagonal());
  const Eigen::PartialPivLU<MatrixXd> lu(c);
  const double expected = -0.5 * data.y.dot(lu.solve(data.y)) -
                          0.5 * lu.matrixLU().diagonal().array().abs().log().sum() -
                          150 * std::log(2 * std::acos(-1.0));
  EXPECT_NEAR(sparse.log_likelihood(), expected, 1e-7 * std::fabs(expected));
  const MatrixXd probe = random_points(10, 2, 95), kpu = data.form->between(data.at.theta, probe, u);
  const MatrixXd sg = (kuu + kuf * g.cwiseInverse().asDiagonal() * kuf.transpose()).inverse();
  EXPECT_LT((sparse.predict(probe).mean - kpu * sg * kuf * data.y.cwiseQuotient(g)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Sparse, WithFewInducingInputsIsNearlyAsGoodOnASmoothFunction) {
  const Data data;
  const SparseGaussianProcess sparse(SparseMethod::fitc, data.form, MeanFunction::zero, data.at, data.x, data.y,
                                     data.x(spread_subset(data.x, 60), Eigen::all));
  const MatrixXd probe = random_points(200, 2, 96);
  const VectorXd error = sparse.predict(probe).mean - first_order_targets(probe, 0, 0);
  EXPECT_LT(std::sqrt(error.squaredNorm() / 200), 0.04);  // below the noise of 0.05
}

TEST(SpreadSubset, ChoosesDifferentRowsAlsoWhereTheyRepeat) {
  MatrixXd x = MatrixXd::Zero(10, 1);
  x(3, 0) = 1;
  const std::vector<Index> rows = spread_subset(x, 10);
  EXPECT_EQ(std::set<Index>(rows.begin(), rows.end()).size(), 10U);
  try {
    spread_subset(x, 11);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "a subset of 11 of 10 rows; there must be from 1 to 10");
  }
}

}  // namespace
}  // namespace plantloop::identify
