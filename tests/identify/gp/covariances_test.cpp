// Facts about every covariance function, and about sums and products of them.

#include "identify/gp/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "identify/error.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<std::string> all_texts() {
  std::vector<std::string> texts{"se_ard + linear", "periodic*se_ard", "linear*(matern_3_2 + neural_network) + linear"};
  for (const CovarianceType& type : covariances()) texts.emplace_back(type.name);
  return texts;
}

class EveryCovariance : public ::testing::TestWithParam<std::string> {
 protected:
  std::shared_ptr<const Covariance> form = find_covariance(GetParam());
  MatrixXd x = random_points(12, 3, 1), z = random_points(7, 3, 2);
  VectorXd theta = random_positive(form->count(3), 3);
};

TEST_P(EveryCovariance, IsReadBackFromItsName) { EXPECT_EQ(find_covariance(form->name())->name(), form->name()); }

TEST_P(EveryCovariance, GivesTheSameNumbersInAllForms) {
  const MatrixXd full = form->between(theta, x, x), low = form->lower(theta, x);
  EXPECT_LT((full - full.transpose()).cwiseAbs().maxCoeff(), 1e-14 * full.cwiseAbs().maxCoeff());
  const MatrixXd expected = full.triangularView<Eigen::Lower>();
  EXPECT_LT((low - expected).cwiseAbs().maxCoeff(), 1e-14 * full.cwiseAbs().maxCoeff());
  EXPECT_LT((form->at(theta, x) - full.diagonal()).cwiseAbs().maxCoeff(), 1e-14 * full.cwiseAbs().maxCoeff());
}

TEST_P(EveryCovariance, IsPositiveDefinite) {
  const MatrixXd k = form->between(theta, x, x);
  const VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<MatrixXd>(k).eigenvalues();
  EXPECT_GT(eigenvalues.minCoeff(), -1e-13 * eigenvalues.maxCoeff());
}

TEST_P(EveryCovariance, HasTheGradientOfItsHyperparameters) {
  // Differences of order 4: their error is about eps^(4/5).
  MatrixXd weight = random_points(12, 12, 5);
  weight = (weight + weight.transpose()).eval();
  const VectorXd gradient = form->gradient(theta, x, form->lower(theta, x), weight);
  ASSERT_EQ(gradient.size(), theta.size());
  const double h = 1e-3;
  for (Index p = 0; p < theta.size(); ++p) {
    const auto at = [&](double step) {
      VectorXd moved = theta;
      moved[p] *= std::exp(step);
      return (weight.array() * form->between(moved, x, x).array()).sum();
    };
    const double expected = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    EXPECT_NEAR(gradient[p], expected, 1e-8 * std::max(1.0, gradient.cwiseAbs().maxCoeff()))
        << form->names(3)[static_cast<std::size_t>(p)];
  }
}

TEST_P(EveryCovariance, HasTheGradientsBetweenTwoSetsOfPoints) {
  const MatrixXd weight = random_points(12, 7, 5);
  MatrixXd by_z;
  const VectorXd gradient = form->cross_gradient(theta, x, z, form->between(theta, x, z), weight, &by_z);
  EXPECT_EQ(form->cross_gradient(theta, x, z, form->between(theta, x, z), weight, nullptr), gradient);
  const VectorXd own_weight = random_points(12, 1, 6), own = form->own_gradient(theta, x, own_weight);
  ASSERT_EQ(gradient.size(), theta.size());
  ASSERT_EQ(own.size(), theta.size());
  const double h = 1e-3;
  const auto difference = [h](const auto& at) { return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h); };
  const double scale = std::max({1.0, gradient.cwiseAbs().maxCoeff(), own.cwiseAbs().maxCoeff()});
  for (Index p = 0; p < theta.size(); ++p) {
    const auto moved = [&](double step) {
      VectorXd there = theta;
      there[p] *= std::exp(step);
      return there;
    };
    EXPECT_NEAR(gradient[p],
                difference([&](double s) { return weight.cwiseProduct(form->between(moved(s), x, z)).sum(); }),
                1e-8 * scale);
    EXPECT_NEAR(own[p], difference([&](double s) { return own_weight.dot(form->at(moved(s), x)); }), 1e-8 * scale);
  }
  for (Index j = 0; j < z.rows(); ++j) {
    for (Index d = 0; d < 3; ++d) {
      const auto at = [&](double step) {
        MatrixXd there = z;
        there(j, d) += step;
        return weight.cwiseProduct(form->between(theta, x, there)).sum();
      };
      EXPECT_NEAR(by_z(j, d), difference(at), 1e-8 * std::max(1.0, by_z.cwiseAbs().maxCoeff()));
    }
  }
}

TEST_P(EveryCovariance, ReadsOnlyTheLowerTriangleOfAWeight) {
  MatrixXd weight = random_points(12, 12, 5);
  weight = (weight + weight.transpose()).eval();
  MatrixXd half = weight.triangularView<Eigen::Lower>();
  const MatrixXd values = form->lower(theta, x);
  EXPECT_TRUE(form->gradient(theta, x, values, weight).isApprox(form->gradient(theta, x, values, half), 1e-13));
}

TEST_P(EveryCovariance, HasTheGradientOfItsInput) {
  const VectorXd at = x.row(0);
  const MatrixXd gradient = form->input_gradient(theta, at, z);
  const double h = 1e-5;
  for (Index d = 0; d < 3; ++d) {
    VectorXd up = at, down = at;
    up[d] += h, down[d] -= h;
    const VectorXd expected =
        (form->between(theta, z, up.transpose()) - form->between(theta, z, down.transpose())) / (2 * h);
    EXPECT_LT((gradient.col(d) - expected).cwiseAbs().maxCoeff(), 1e-8 * std::max(1.0, expected.cwiseAbs().maxCoeff()));
  }
}

TEST_P(EveryCovariance, StartsFromAGuessThatCanBeUsed) {
  const VectorXd guess = form->guess(x, 2.0);
  ASSERT_EQ(guess.size(), form->count(3));
  EXPECT_GT(guess.minCoeff(), 0);
}

INSTANTIATE_TEST_SUITE_P(Texts, EveryCovariance, ::testing::ValuesIn(all_texts()), [](const auto& text) {
  std::string name = text.param;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
});

// By hand, for the points (1, 2) and (0.5, -1).
class KnownValue : public ::testing::Test {
 protected:
  double of(const std::string& text, const std::vector<double>& theta) {
    MatrixXd a(1, 2), b(1, 2);
    a << 1, 2;
    b << 0.5, -1;
    return find_covariance(text)->between(VectorXd::Map(theta.data(), static_cast<Index>(theta.size())), a, b)(0, 0);
  }
  double s = 0.4 * 0.25 + 0.3 * 9;  // with w = (0.4, 0.3)
};

TEST_F(KnownValue, OfTheSquaredExponential) { EXPECT_NEAR(of("se_ard", {0.4, 0.3, 2}), 2 * std::exp(-s / 2), 1e-15); }
TEST_F(KnownValue, OfMatern) {
  const double a = std::sqrt(3 * s), b = std::sqrt(5 * s);
  EXPECT_NEAR(of("matern_3_2", {0.4, 0.3, 2}), 2 * (1 + a) * std::exp(-a), 1e-15);
  EXPECT_NEAR(of("matern_5_2", {0.4, 0.3, 2}), 2 * (1 + b + b * b / 3) * std::exp(-b), 1e-15);
}
TEST_F(KnownValue, OfTheRationalQuadratic) {
  EXPECT_NEAR(of("rational_quadratic", {0.4, 0.3, 2, 1.5}), 2 * std::pow(1 + s / 3, -1.5), 1e-15);
}
TEST_F(KnownValue, OfThePeriodicForm) {
  const double pi = std::acos(-1.0);
  const double sum = 0.4 * std::pow(std::sin(pi * 0.5 / 2), 2) + 0.3 * std::pow(std::sin(pi * 3 / 5), 2);
  EXPECT_NEAR(of("periodic", {0.4, 0.3, 2, 5, 2}), 2 * std::exp(-2 * sum), 1e-15);
}
TEST_F(KnownValue, OfTheLinearForm) { EXPECT_NEAR(of("linear", {0.4, 0.3, 2}), 2 + 0.4 * 0.5 - 0.3 * 2, 1e-15); }
TEST_F(KnownValue, OfTheNeuralNetwork) {
  const double aa = 2 + 0.4 + 0.3 * 4, bb = 2 + 0.4 * 0.25 + 0.3, ab = 2 + 0.4 * 0.5 - 0.3 * 2;
  EXPECT_NEAR(of("neural_network", {0.4, 0.3, 2, 1.5}),
              1.5 * 2 / std::acos(-1.0) * std::asin(2 * ab / std::sqrt((1 + 2 * aa) * (1 + 2 * bb))), 1e-15);
}

std::string complaint(const std::string& text) {
  try {
    find_covariance(text);
  } catch (const IdentifyError& error) {
    return error.what();
  }
  return "none";
}

TEST(CovarianceText, SaysWhatIsWrong) {
  const std::string all = "linear, matern_3_2, matern_5_2, neural_network, periodic, rational_quadratic, se_ard";
  EXPECT_EQ(complaint("se_ard + rbf"), "covariance 'se_ard + rbf': there is no covariance 'rbf'; there are " + all);
  EXPECT_EQ(complaint("se_ard +"), "covariance 'se_ard +': the name of a covariance is missing; there are " + all);
  EXPECT_EQ(complaint("(se_ard"), "covariance '(se_ard': a ')' is missing");
  EXPECT_EQ(complaint("se_ard linear"), "covariance 'se_ard linear': 'linear' is not expected there");
}

}  // namespace
}  // namespace plantloop::identify
