// pl.sweep and pl.fit.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

class Studies : public Workshop {
 protected:
  Studies() { write_lag(); }
  std::string with_lag(const std::string& script) {
    return "local pl = require 'plantloop'\nlocal lag = pl.load 'lag.yaml'\n" + script;
  }
};

TEST_F(Studies, ASweepIsAListOfRunsWithTheirSettings) {
  EXPECT_EQ(printed(with_lag(R"lua(
local points = pl.sweep{diagram = lag, grid = {tau = pl.vector{0.5, 1}}, stop = 3}
for _, p in ipairs(points) do
  print(p.set.tau, ("%.4f"):format(p.run.y[#p.run.y]), ("%.4f"):format(1 - math.exp(-2/p.set.tau)), p.failure)
end
)lua")),
            "0.5\t0.9817\t0.9817\tnil\n1.0\t0.8647\t0.8647\tnil");
}

TEST_F(Studies, ASweepOfDrawsDoesNotDependOnThreads) {
  const std::string script = R"lua(
local function last(threads)
  local sum = ""
  for _, p in ipairs(pl.sweep{diagram = lag, random = {tau = {"uniform", 0.5, 2}}, draws = 20, seed = 4, threads = threads}) do
    sum = sum .. p.set.tau .. p.run.y[#p.run.y]
  end
  return sum
end
print(last(1) == last(3))
)lua";
  EXPECT_EQ(printed(with_lag(script)), "true");
}

TEST_F(Studies, AFailureStaysWithItsPoint) {
  EXPECT_EQ(printed(with_lag(R"lua(
local points = pl.sweep{diagram = lag, list = {tau = {1, -1}}}
print(points[1].run ~= nil, points[2].run, points[2].failure:find("must be at least") ~= nil)
)lua")),
            "true\tnil\ttrue");
}

TEST_F(Studies, AFitGivesTheParametersBackThatMadeTheData) {
  EXPECT_EQ(printed(with_lag(R"lua(
local t = pl.linspace(1.2, 4, 15)
local fit = pl.fit{diagram = lag, parameters = {"tau"}, bounds = {tau = {0.1, 5}}, data = {time = t, y = 1 - pl.exp(-(t - 1)/0.7)}}
print(fit.converged, fit.derivatives, ("%.8f"):format(fit.values.tau), fit.rms.y < 1e-8, #fit.fitted.y, fit.parameters[1])
)lua")),
            "true\texact\t0.70000000\ttrue\t15\ttau");
}

TEST_F(Studies, AFitSharesParametersBetweenExperiments) {
  EXPECT_EQ(printed(with_lag(R"lua(
local line = pl.diagram "plantloop: 1\nparameters: {a: 0, b: 0, c: 0}\nblocks: {y: a + b*time + c}\nsimulation: {stop: 5}\n"
local fit = pl.fit{diagram = line, parameters = {"a", "b"}, weights = {y = 2}, data = {
  {time = {0, 1}, y = {1, 2.5}, set = {c = 0}},
  {time = {2, 3, 4}, y = {7, 9, 9.2}, set = {c = 5}},
}}
print(("%.9f"):format(fit.values.b), #fit.fitted, #fit.fitted[2].y, fit.rms[1].y < 1)
)lua")),
            "0.790000000\t2\t3\ttrue");
}

TEST_F(Studies, SayWhatIsWrong) {
  EXPECT_THAT(complaint(with_lag("pl.sweep{grid = {tau = {1}}}")), HasSubstr("'diagram' must be a diagram"));
  EXPECT_THAT(complaint(with_lag("pl.sweep{diagram = lag, grid = {1}}")), HasSubstr("'grid' has entries by path"));
  EXPECT_THAT(complaint(with_lag("pl.sweep{diagram = lag, random = {tau = 1}}")),
              HasSubstr("a distribution and two numbers for each path"));
  EXPECT_THAT(complaint(with_lag("pl.sweep{diagram = lag, grid = {tau = {1}}, tread = 1}")), HasSubstr("tread"));
  EXPECT_THAT(complaint(with_lag("pl.fit{diagram = lag, parameters = {'tau'}}")),
              HasSubstr("'data' is a table of vectors"));
  EXPECT_THAT(complaint(with_lag("pl.fit{diagram = lag, parameters = {'tau'}, data = {y = {1}}}")),
              HasSubstr("'data' has no 'time'"));
  EXPECT_THAT(complaint(with_lag(
                  "pl.fit{diagram = lag, parameters = {'tau'}, bounds = {k = {1, 2}}, data = {time = {1}, y = {1}}}")),
              HasSubstr("'bounds' has 'k', which is not among the fitted parameters"));
  EXPECT_THAT(complaint(with_lag("pl.fit{diagram = lag, parameters = 'tau', data = {time = {1}, y = {1}}}")),
              HasSubstr("'parameters' is a table of paths"));
}

}  // namespace
}  // namespace plantloop
