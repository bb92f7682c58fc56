// Regressors as text, and the matrices that they make.

#include "identify/regressors/regressors.h"

#include <gtest/gtest.h>

#include <limits>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

std::string shown(const std::string& text, std::vector<std::string> inputs = {"u"},
                  std::vector<std::string> outputs = {"y"}) {
  try {
    return to_text(parse_regressors(text, std::move(inputs), std::move(outputs)));
  } catch (const IdentifyError& e) {
    return e.what();
  }
}

TEST(Regressors, AreReadAndWrittenInOneForm) {
  EXPECT_EQ(shown("y(k-1), y( k - 2 ),u(k-3), u(k-1)^2, u(k-1)*y(k-1), 1, u(k)"),
            "y(k-1), y(k-2), u(k-3), u(k-1)^2, y(k-1)*u(k-1), 1, u(k)");
  EXPECT_EQ(shown("u(k-1..3)"), "u(k-1), u(k-2), u(k-3)");
  EXPECT_EQ(shown("u(k..2)"), "u(k), u(k-1), u(k-2)");
  EXPECT_EQ(shown("y(k-1)*u(k-1..2)*u(k-1)"), "y(k-1)*u(k-1)^2, y(k-1)*u(k-1)*u(k-2)");
  EXPECT_EQ(shown("y2(k-1), flow(k-1), u2(k-1)", {"flow", "heat now"}, {"a", "b"}), "b(k-1), flow(k-1), u2(k-1)");
}

TEST(Regressors, SayWhatIsWrongAndWhere) {
  EXPECT_EQ(shown("y(k-1), u(k+1)"),
            "regressors, character 12: a regressor is of the past: k-1, not k+1\n  y(k-1), u(k+1)\n             ^");
  EXPECT_EQ(
      shown("y(k)"),
      "regressors, character 4: an output is a regressor from k-1 on; at k it is what is predicted\n  y(k)\n     ^");
  EXPECT_EQ(shown("flov(k-1)", {"flow"}),
            "regressors, character 1: there is no signal 'flov', did you mean 'flow'; there are: y, flow\n  flov(k-1)\n"
            "  ^");
  EXPECT_EQ(shown("u(k-1..2), u(k-2)"),
            "regressors, character 12: u(k-2) is there twice\n  u(k-1..2), u(k-2)\n"
            "             ^");
  EXPECT_EQ(
      shown("u(k-1) u(k-2)"),
      "regressors, character 8: a comma between regressors is expected, here is 'u'\n  u(k-1) u(k-2)\n         ^");
  EXPECT_EQ(shown(" "), "there are no regressors; write, for example, 'y(k-1), u(k-1..2)'");
}

TEST(Regressors, MakeOneRowForEachSampleWithAWholePast) {
  const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(6, 10, 60);
  const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(6, 1, 6);
  const DataSet data = make_data_set(u, y, 1);
  const Regression r = make_regression(data, parse_regressors("y(k-1), u(k-2)^2, y(k-2)*u(k-1), 1", data));
  ASSERT_EQ(r.X.rows(), 4);
  EXPECT_EQ(r.X.row(0), Eigen::RowVector4d(2, 100, 20, 1));
  EXPECT_EQ(r.Y(0, 0), 3);
  EXPECT_EQ(r.rows[3].sample, 5);
}

TEST(Regressors, DoNotReachIntoAnotherExperimentOrAcrossAMissingValue) {
  Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(6, 1, 6);
  DataSet data = make_data_set(y, y, 1);
  data = join(data, data);
  const RegressorSet set = parse_regressors("y(k-1), y(k-2)", data);
  EXPECT_EQ(make_regression(data, set).X.rows(), 8);
  data.experiments[1].y(3, 0) = std::numeric_limits<double>::quiet_NaN();
  const Regression r = make_regression(data, set);
  EXPECT_EQ(r.X.rows(), 5);  // the target at 3 and the two rows that see it are missing
  EXPECT_EQ(r.left_out, 3);
}

TEST(Regressors, OfAPolynomialAreAllProductsUpToItsDegree) {
  const RegressorSet single = parse_regressors("y(k-1), u(k-1)", {"u"}, {"y"});
  EXPECT_EQ(to_text(polynomial(single, 2)), "1, y(k-1), u(k-1), y(k-1)^2, y(k-1)*u(k-1), u(k-1)^2");
  // (n + d)! / (n! d!) terms
  const RegressorSet six = parse_regressors("y(k-1..3), u(k-1..3)", {"u"}, {"y"});
  EXPECT_EQ(polynomial(six, 3).size(), 84);
}

}  // namespace
}  // namespace plantloop::identify
