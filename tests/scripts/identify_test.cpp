// Identification from scripts: data, fits, predictions, files, and what is said when something is wrong.

#include <algorithm>
#include <sstream>

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using testing::HasSubstr;

class Identification : public Workshop {
 protected:
  // `data` is of y(k) = 0.8 y(k-1) + 0.5 u(k-1) with a binary input, without noise.
  std::string with_data(const std::string& script) {
    return printed(R"lua(local identify = pl.identify
      local u, y = identify.prbs{bits = 8, hold = 2}, pl.zeros(510)
      for k = 2, #u do y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] end
      local data = identify.data{u = u, y = y, Ts = 0.1, inputs = {"u [V]"}, outputs = {"level [m]"}}
      )lua" + script);
  }
};

TEST_F(Identification, FitsArxAndOutputErrorModels) {
  EXPECT_EQ(with_data(R"lua(
      local arx, oe = identify.arx(data, {na = 1, nb = 1}), identify.oe(data, {nb = 1, nf = 1})
      print(("%s %.6f %.6f %.6f"):format(arx.structure, arx.A[2], arx.B[1], arx.gain))
      print(("%s %.6f %.6f"):format(oe.structure, oe.F[2], oe.B[1]))
      print(("%.9f"):format(identify.metrics(data.y, oe:simulate(data)).max)))lua"),
            "ARX -0.800000 0.500000 2.500000\nOE -0.800000 0.500000\n0.000000000");
}

// The record is cut out of a run about level 3; the true constant of the ARX model is 3 (1 - 0.8).
TEST_F(Identification, EstimatesAConstantAndThePastOfTheRecord) {
  EXPECT_EQ(
      with_data(R"lua(
      local cut = identify.data{u = data:part(100, 160).u, y = data:part(100, 160).y + 3, Ts = 0.1}
      local arx = identify.arx(cut, {na = 1, nb = 1, offset = true})
      print(("%.6f %.6f %s"):format(arx.offset, arx.level, arx.names[3]))
      local oe = identify.oe(cut, {nb = 1, nf = 1, offset = true})
      print(("%.6f %.6f %.6f %s"):format(oe.offset, oe.F[2], oe.B[1], oe.initial))
      print(("%.6f"):format(identify.metrics(cut.y, oe:predict(cut)).max),
            identify.metrics(cut.y, oe:predict(cut, 1, {initial = "rest"})).max > 0.1)
      local rest = identify.oe(cut, {nb = 1, nf = 1, initial = "rest"})
      print(rest.offset, rest.initial)
      print(("%.6f"):format(identify.filtered(cut, {na = 1, nb = 1, offset = true}).offset))
      oe:save "oe.yaml"
      print(identify.load "oe.yaml":simulate(cut) == oe:simulate(cut))
      local ss = identify.state_space(cut, {order = 1, block_rows = 5, offset = true})
      print(("%.6f %.6f"):format(identify.metrics(cut.y, ss:simulate(cut)).max, ss.level[1]))
      print(pcall(identify.oe, cut, {initial = "zero"})))lua"),
      "0.600000 3.000000 offset\n3.000000 -0.800000 0.500000 estimate\n0.000000\ttrue\nnil\trest\n3.000000\ntrue\n"
      "0.000000 3.000000\nfalse\t'initial' must be rest or estimate, it is the text 'zero'");
}

TEST_F(Identification, FitsOfTheFreeRunListTheirOptions) {
  EXPECT_EQ(
      with_data(R"lua(
      local mlp = identify.mlp(data, {regressors = "y(k-1), u(k-1)", hidden = {2}, starts = 1})
      local linear = identify.regression(data, {regressors = "y(k-1), u(k-1)"})
      print(select(2, pcall(mlp.prune, mlp, data, {tests = data})))
      print(select(2, pcall(mlp.fit_free_run, mlp, data, {rounds = 3})))
      print(select(2, pcall(linear.fit_free_run, linear, data, {rounds = 3})))
      print(select(2, pcall(linear.fit_free_run, linear, data, {iterations = 0})))
      print(("%.6f"):format(linear:fit_free_run(data, {iterations = 5}).theta[1])))lua"),
      "the options of prune: there is no 'tests'; did you mean 'test'?  it has: test, decay, iterations, least\n"
      "the options of fit_free_run: there is no 'rounds'; it has: iterations, decay, horizons, validation, patience\n"
      "the options of fit_free_run: there is no 'rounds'; it has: iterations\n"
      "'iterations' must be 1 or more\n0.800000");
}

TEST_F(Identification, EveryFitReports) {
  EXPECT_EQ(with_data(R"lua(
      local r = identify.arx(data, {na = 2, nb = 2}).report
      print(r.method, r.parameters, r.samples, r.warnings[1])
      print(#identify.armax(data, {na = 1, nb = 1, nc = 1}).report.tried))lua"),
            "least squares\t4.0\t508.0\tthe data determine only 3 of 4 parameters: one is set to 0. The input does not "
            "excite the process enough, or a regressor is a combination of others\n2");
}

TEST_F(Identification, DataKeepNamesUnitsAndParts) {
  EXPECT_EQ(with_data(R"lua(
      local first, second = data:split(0.6)
      print(data.samples, first.samples, second.samples, data.inputs[1], data.outputs[1], #data:column "level", data.Ts)
      print(data:part(11, 20).time)
      data:save "out.csv"
      print(identify.read("out.csv", {inputs = {"u"}, outputs = {"level"}}).hash == data.hash))lua"),
            "510\t306\t204\tu\tlevel\t510\t0.1\n[1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9]\ntrue");
}

TEST_F(Identification, EveryModelPredictsLeavesResidualsAndRunsFromRest) {
  EXPECT_EQ(with_data(R"lua(
      local short, lags = data:part(100, 200), "level(k-1), u(k-1)"
      local models = {identify.arx(data, {na = 1, nb = 1}), identify.state_space(data, {order = 1}),
                      identify.regression(data, {regressors = lags}),
                      identify.local_models(data, {regressors = lags, models = 1}),
                      identify.neural_state_space(data, {order = 1, hidden = 0, starts = 1, iterations = 50})}
      -- y(k) = 0.8 y(k-1) + 0.5 u(k-1) from y = u = 0 before the first sample.
      local rest = pl.zeros(#short.u)
      for k = 2, #rest do rest[k] = 0.8 * rest[k - 1] + 0.5 * short.u[k - 1] end
      for i, m in ipairs(models) do
        local e, p = m:residuals(short), m:predict(short)
        local first = 3
        local tail = e:slice(first, #e) - (short.y:slice(first, #e) - p:slice(first, #e))
        print(#e, tail:abs():max() < 1e-12, e:slice(first, #e):abs():max() < 1e-3,
              -- The state 0 of the last one is the middle of its data.
              i == #models or (m:simulate(short, {start = "zero"}) - rest):slice(first, #e):abs():max() < 1e-3)
      end)lua"),
            "101\ttrue\ttrue\ttrue\n101\ttrue\ttrue\ttrue\n101\ttrue\ttrue\ttrue\n101\ttrue\ttrue\ttrue\n101\ttrue\ttru"
            "e\ttrue");
}

TEST_F(Identification, AnErrorWithoutAPlaceIsToldWithoutATrace) {
  const ScriptResult result =
      run("local function f() error('the record is too short', 0) end\nlocal function g() f() end\ng()");
  EXPECT_EQ(result.messages, "the record is too short\n");
}

TEST_F(Identification, LearnersSayWhatMissingValuesCost) {
  EXPECT_EQ(with_data(R"lua(
      local holed = data.y:slice(1, 510)
      holed[100] = pl.nan
      local gap = identify.data{u = data.u, y = holed, Ts = 0.1}
      for _, m in ipairs{identify.rbf_network(gap, {regressors = "y(k-1), u(k-1)", functions = 5}),
                         identify.local_models(gap, {regressors = "y(k-1), u(k-1)", models = 2})} do
        print(m.report.warnings[#m.report.warnings])
      end)lua"),
            "2 rows with missing values were left out.\n2 rows with missing values were left out.");
}

TEST_F(Identification, ModelsComeBackFromTheirFiles) {
  EXPECT_EQ(with_data(R"lua(
      local models = {identify.oe(data, {nb = 1, nf = 1}), identify.state_space(data, {order = 1}),
                      identify.regression(data, {regressors = "y(k-1), u(k-1), 1", normalise = true})}
      for i, m in ipairs(models) do
        m:save(("m%d.yaml"):format(i))
        print(identify.load(("m%d.yaml"):format(i)):simulate(data) == m:simulate(data))
      end)lua"),
            "true\ntrue\ntrue");
  EXPECT_THAT(read("m1.yaml"), HasSubstr("plantloop_model: 1\ntype: linear_model\nstructure: OE\nTs: 0.1\n"));
}

TEST_F(Identification, LearnsNeuralStateSpaceModels) {
  EXPECT_THAT(with_data(R"lua(
      local short = data:part(1, 150)
      local m = identify.neural_state_space(short, {order = 1, hidden = 2, output_hidden = {3}, starts = 2, iterations = 20})
      m:save("n.yaml")
      local again = identify.load("n.yaml")
      print(again:simulate(short) == m:simulate(short), again:simulate(short, {start = "zero"}) == m:simulate(short))
      print(m.order, m.Ts, #m.deviations, #m.report.tried > 0)
      local better = m:fit_free_run(short, {iterations = 30})
      print(better.report.reached < m.report.reached)
      print(select(2, pcall(identify.neural_state_space, short, {neurons = 3})))
      print(select(2, pcall(m.simulate, m, short, {start = "rest"}))))lua"),
              testing::AllOf(HasSubstr("true\tfalse\n1\t0.1\t1\ttrue\ntrue\n"),
                             HasSubstr("the options of neural_state_space: there is no 'neurons'"),
                             HasSubstr("estimated or zero")));
}

TEST_F(Identification, LearnsNetworksLocalModelsAndGaussianProcesses) {
  EXPECT_EQ(with_data(R"lua(
      local regressors = "y(k-1), u(k-1)"
      local short = data:part(1, 120)
      local models = {identify.mlp(short, {regressors = regressors, hidden = 2, starts = 2, iterations = 30}),
                      identify.rbf_network(short, {regressors = regressors, functions = 5}),
                      identify.local_models(short, {regressors = regressors, models = 2}),
                      identify.gaussian_process(short, {regressors = regressors, starts = 1, points = 40})}
      for i, m in ipairs(models) do
        m:save(("l%d.yaml"):format(i))
        print(m.type, identify.load(("l%d.yaml"):format(i)):simulate(short) == m:simulate(short), #m.report.tried > 0)
      end
      local mean, variance = models[4]:uncertain(short, {propagation = "first_order"})
      print(#mean, variance[2] > 0, models[1]:prune(short).report.method))lua"),
            "mlp\ttrue\ttrue\nrbf_network\ttrue\ttrue\nlocal_model_network\ttrue\ttrue\ngaussian_process\ttrue\ttrue\n"
            "120\ttrue\toptimal brain surgeon");
}

// Variances are the diagonal of each row's covariances.
TEST_F(Identification, CarriesTheUncertaintyOfSeveralOutputs) {
  EXPECT_EQ(printed(R"lua(
      local I = pl.identify
      local u = I.staircase{samples = 80, hold = 4, lower = -1, upper = 1, seed = 1}
      local rows = {{0, 0}}
      for k = 2, 80 do
        local a, b = rows[k - 1][1], rows[k - 1][2]
        rows[k] = {0.7*a + 0.2*b + 0.3*u[k - 1], 0.5*b - 0.4*math.sin(a)}
      end
      local d = I.data{u = u, y = pl.matrix(rows), Ts = 1}
      local m = I.gaussian_process(d, {regressors = "y1(k-1), y2(k-1), u(k-1)", starts = 1, iterations = 30})
      for _, how in ipairs{"naive", "first_order", "moment_matching"} do
        local mean, variance, covariance = m:uncertain(d, {propagation = how})
        print(#mean[80], #covariance[80], covariance(80, 1) == variance(80, 1), covariance(80, 4) == variance(80, 2),
              covariance(80, 2) == covariance(80, 3), covariance(80, 2) ~= 0)
      end)lua"),
            "2\t4\ttrue\ttrue\ttrue\tfalse\n2\t4\ttrue\ttrue\ttrue\ttrue\n2\t4\ttrue\ttrue\ttrue\ttrue");
}

// A quadratic function of a normal variable: E x^2 = 0.3^2 + 0.04, var x^2 = 2*0.04^2 + 4*0.3^2*0.04, cov(x^2, x) =
// 2*0.3*0.04.
TEST_F(Identification, CarriesTheUncertaintyOfAPointAlong) {
  const std::string made =
      "local x = pl.linspace(-2, 2, 41)\n"
      "local d = pl.identify.data{u = x, y = x^2, Ts = 1}\n"
      "local m = pl.identify.gaussian_process(d, {regressors = 'u(k)', covariance = 'se_ard + linear*linear', "
      "starts = 2, iterations = 60})\n";
  EXPECT_EQ(printed(made + "for _, how in ipairs{'first_order', 'moment_matching'} do\n"
                           "  local y, C, cross = m:propagate({0.3}, {0.04}, {propagation = how})\n"
                           "  print(('%.3f %.4f %.3f'):format(y[1], C(1, 1), cross(1, 1)))\nend"),
            "0.090 0.0144 0.024\n0.130 0.0176 0.024");
  EXPECT_THAT(complaint(made + "m:propagate({0.3, 1}, {0.04})"), HasSubstr("the point has 2 inputs, the model 1"));
  EXPECT_THAT(complaint(made + "m:propagate({0.3}, {-0.04})"),
              HasSubstr("the covariance of the point has the eigenvalue -0.04; no variance is below 0"));
}

TEST_F(Identification, TrainsNetworksOnThroughTime) {
  EXPECT_EQ(printed("local I = pl.identify\n"
                    "local u = I.staircase{samples = 300, hold = 5, lower = -1, upper = 1, seed = 1}\n"
                    "local y = pl.zeros(300)\n"
                    "for k = 2, 300 do y[k] = 0.8 * y[k - 1] + 0.4 * u[k - 1]/(1 + math.abs(u[k - 1])) end\n"
                    "local d = I.data{u = u, y = y, Ts = 1}\n"
                    "local m = I.mlp(d, {regressors = 'y(k-1), u(k-1)', hidden = 3, direct = true, starts = 2,\n"
                    "                    iterations = 5})\n"
                    "local n = m:fit_free_run(d, {iterations = 30, horizons = {20, 0}})\n"
                    "local function error_of(m) return I.metrics(y, m:simulate(d)).RMSE end\n"
                    "print(error_of(n) < 0.5 * error_of(m), error_of(n) < 0.01)"),
            "true\ttrue");
}

TEST_F(Identification, TakesLinearModelsIntoAGaussianProcess) {
  EXPECT_EQ(with_data("local noisy = identify.data{u = u, y = y + identify.white_noise{samples = #y, deviation = 0.01, "
                      "seed = 3}, Ts = 0.1, inputs = {'u'}, outputs = {'level'}}\n"
                      "local linear = identify.arx(noisy, {na = 1, nb = 1, remove_means = true})\n"
                      "local how = {regressors = 'level(k-1), u(k-1)', starts = 1, local_models = {linear}}\n"
                      "local m = identify.gaussian_process(noisy:part(1, 20), how)\n"
                      "m:save 'local.yaml'\n"
                      "print(identify.load('local.yaml'):simulate(noisy) == m:simulate(noisy))"),
            "true");
  EXPECT_THAT(complaint("local d = pl.identify.data{u = pl.linspace(0, 1, 20), y = pl.linspace(0, 1, 20)^2, Ts = 1}\n"
                        "pl.identify.gaussian_process(d, {regressors = 'y(k-1)', local_models = {3}})"),
              HasSubstr("'local_models' must be a linear model, it is 3"));
}

TEST_F(Identification, FitsModelsOfTheNoise) {
  const std::string plant =
      "local v = identify.white_noise{samples = #y, deviation = 0.1, seed = 3}\n"
      "local z = pl.zeros(#y)\n"
      "for k = 2, #y do z[k] = 0.7*z[k - 1] + 0.5*u[k - 1] + v[k] + 0.6*v[k - 1] end\n"
      "local d = identify.data{u = u, y = z, Ts = 0.1}\n";
  EXPECT_EQ(
      with_data(plant +
                "local how = {regressors = 'y(k-1), u(k-1), e(k-1)', structure = 'NARMAX', hidden = 2, starts = 2,"
                " iterations = 60}\n"
                "local a = identify.mlp(d, how)\n"
                "local b = identify.mlp(d, {regressors = 'y(k-1), u(k-1)', structure = 'NBJ', nc = 1, nd = 1,\n"
                "                           hidden = 2, starts = 2, iterations = 60})\n"
                "print(a.structure, #a.C, b.structure, #b.C, #b.D)\n"
                "a:save 'narmax.yaml'\n"
                "print(identify.load('narmax.yaml'):simulate(d) == a:simulate(d))"),
      "NARMAX\t0\tNBJ\t2\t2\ntrue");
  const auto refused = [&](const std::string& asked) {
    return complaint(
        "local d = pl.identify.data{u = pl.linspace(0, 1, 20), y = pl.linspace(0, 1, 20)^2, Ts = 1}\n"
        "pl.identify.mlp(d, {" +
        asked + "})");
  };
  EXPECT_THAT(refused("regressors = 'y(k-1)', structure = 'NARMAX'"),
              HasSubstr("NARMAX needs a noise model: regressors such as e(k-1), or nc = 1"));
  EXPECT_THAT(refused("regressors = 'y(k-1)', structure = 'NBJ'"),
              HasSubstr("NBJ needs an order of its noise filter, as in nc = 1, nd = 1"));
  EXPECT_THAT(refused("regressors = 'y(k-1), e(k-1)', structure = 'NARX'"),
              HasSubstr("NARX has no noise model, but there are prediction errors e(k-1) or orders nc, nd"));
  EXPECT_THAT(refused("regressors = 'y(k-1), u(k)', structure = 'NFIR'"),
              HasSubstr("NFIR has no regressors of outputs"));
  EXPECT_THAT(refused("regressors = 'u(k)', structure = 'NOE'"),
              HasSubstr("NOE has past outputs among its regressors, as y(k-1)"));
  EXPECT_THAT(refused("regressors = 'u(k)', structure = 'ARX'"), HasSubstr("NFIR, NARX, NOE, NARMAX or NBJ"));
}

TEST_F(Identification, TellsTheWeightsOfANetworkAsAFigureTakesThem) {
  EXPECT_EQ(with_data("local m = identify.mlp(data, {regressors = 'level(k-1), u(k-1)', hidden = 3, starts = 1})\n"
                      "print(m.layers:table()[1], m.layers:table()[2], m.layers:table()[3], #m.weights)\n"
                      "pl.figure{title = 'n'}:network(m.layers, {weights = m.weights})"),
            "2.0\t3.0\t1.0\t9");
  EXPECT_THAT(complaint("local d = pl.identify.data{u = pl.linspace(0, 1, 20), y = pl.linspace(0, 1, 20)^2, Ts = 1}\n"
                        "print(pl.identify.local_models(d, {regressors = 'u(k)', models = 2}).layers)"),
              HasSubstr("only an mlp has layers, this is a local_model_network"));
}

TEST_F(Identification, AddsMeasurementsToAGaussianProcess) {
  EXPECT_EQ(
      with_data(
          "local noise = identify.white_noise{samples = #y, deviation = 0.02, seed = 3}\n"
          "local noisy = identify.data{u = u, y = y + noise, Ts = 0.1, inputs = {'u'}, outputs = {'level'}}\n"
          "local first, rest = noisy:part(1, 60), noisy:part(61, 120)\n"
          "local m = identify.gaussian_process(first, {regressors = 'level(k-1), u(k-1)', starts = 1})\n"
          "local more = m:add(rest)\n"
          "local function spread(x) local _, v = x:uncertain(rest, {propagation = 'naive'}); return pl.mean(v) end\n"
          "print(spread(more) < spread(m), more.report.samples - m.report.samples)\n"
          "more:save 'more.yaml'\n"
          "print(identify.load('more.yaml'):simulate(rest) == more:simulate(rest))"),
      "true\t59.0\ntrue");
  EXPECT_THAT(complaint("local d = pl.identify.data{u = pl.linspace(0, 1, 20), y = pl.linspace(0, 1, 20)^2, Ts = 1}\n"
                        "pl.identify.local_models(d, {regressors = 'u(k)', models = 2}):add(d)"),
              HasSubstr("only a gaussian_process takes in single measurements, this is a local_model_network"));
}

// Numbers of 50 digits, as in the tests of identify/gp; `rows` and `m` are the process that they are of.
const std::string seven_points = R"lua(local gp = pl.identify.gaussian_process
      local X = {{0.10, -0.70}, {-0.45, 0.30}, {0.80, 0.55}, {-1.20, -0.15}, {0.33, 1.10}, {-0.66, -0.98}, {1.50, -0.24}}
      local y = {0.42, -0.17, 0.93, -0.58, 0.77, -1.05, 1.20}
      local how = {covariance = "se_ard", hyperparameters = {w1 = 0.8, w2 = 1.7, v1 = 1.3, v0 = 0.05}}
      local m = gp(X, y, how)
      )lua";

TEST_F(Identification, EvaluatesAGaussianProcessAtGivenHyperparameters) {
  EXPECT_EQ(printed(seven_points + R"lua(
      local g, loo = m:gradient(), m:leave_one_out()
      print(("%.11f"):format(m:log_likelihood()))
      print(("%.11f %.11f %.11f %.11f"):format(g.w1, g.w2, g.v1, g.v0))
      local mean, variance, measured = m:predict{{0.25, -0.40}, {-0.90, 1.30}}
      print(("%.11f %.11f %.11f"):format(mean[1], variance[1], measured[1]))
      print(("%.11f %.11f %.11f"):format(mean[2], variance[2], measured[2]))
      print(("%.11f %.11f %.11f"):format(loo.mean[1], loo.variance[1], loo.log_probability))
      print(pl.sum(loo.log_density) - loo.log_probability == 0, m:hyperparameters().w2, m.report.stopped))lua"),
            "-7.91478371219\n"
            "-0.06020885543 -0.84329896634 -1.37790542363 -0.08043977156\n"
            "0.67955179749 0.10908723932 0.15908723932\n"
            "0.12477372717 0.78378871189 0.83378871189\n"
            "-0.44245457596 0.48336353186 -6.80989483706\n"
            "true\t1.7\tnothing was trained");
}

TEST_F(Identification, EvaluatesGaussianProcessesOfDataSetsAndSeveralOutputs) {
  EXPECT_EQ(printed(seven_points + R"lua(
      local data = pl.identify.data{u = X, y = y, Ts = 1}
      how.regressors = "u1(k), u2(k)"
      print(gp(data, how):log_likelihood() == m:log_likelihood())
      local both = {}
      for i = 1, #y do both[i] = {y[i], 2 * y[i]} end
      how.regressors = nil
      local first, second = how.hyperparameters, {w1 = 0.8, w2 = 1.7, v1 = 5.2, v0 = 0.2}
      how.hyperparameters = {first, second}
      local two = gp(X, both, how)
      print(("%.12f %.12f"):format(two:log_likelihood(1) - m:log_likelihood(),
                                 two:log_likelihood(2) + #y * math.log(2) - m:log_likelihood()))
      local mean = two:predict{{0.25, -0.40}}
      print(("%.12f"):format(mean(1, 2) - 2 * mean(1, 1)))
      m:save "seven.yaml"
      print(pl.identify.load("seven.yaml"):log_likelihood() == m:log_likelihood())
      -- All rows, of which training would take some.
      local many = gp(pl.linspace(0, 1, 1100), pl.linspace(0, 1, 1100)^2, {hyperparameters = {w1 = 9, v1 = 1, v0 = 0.01}})
      print(#many:leave_one_out().mean, #many.report.warnings))lua"),
            "true\n0.000000000000 0.000000000000\n0.000000000000\ntrue\n1100\t0");
}

TEST_F(Identification, SeesLargeSetsThroughInducingInputs) {
  // At given hyperparameters and inducing inputs: numbers of 40 digits, as in the tests of identify/gp.
  EXPECT_EQ(printed(seven_points + R"lua(
      how.inducing = {{-0.80, -0.60}, {0.20, 0.40}, {1.10, -0.05}}
      for _, approximation in ipairs{"fitc", "vfe"} do
        how.approximation = approximation
        local s = gp(X, y, how)
        local g, by_inducing = s:gradient()
        local mean, variance = s:predict{{0.25, -0.40}}
        print(("%.10f %.10f %.10f %.10f %.10f"):format(s:log_likelihood(), g.w1, by_inducing(1, 2), mean[1], variance[1]))
        print(s:inducing()[3] == pl.vector{1.10, -0.05}, ("%.10f"):format(s:leave_one_out().mean[7]))
      end)lua"),
            "-7.5605277059 -0.2373328278 0.8215213055 0.3036813932 0.4485611709\ntrue\t0.7805603923\n-33.3319176365 "
            "-9.9896577167 0.0490303089 0.3889771182 0.3754675775\ntrue\t1.4100826366");
  EXPECT_THAT(
      printed(R"lua(local identify = pl.identify
      local u = identify.white_noise{samples = 400, deviation = 1, seed = 2}
      local e = identify.white_noise{samples = 400, deviation = 0.03, seed = 3}
      local y = pl.zeros(400)
      local function bend(x) return x / math.sqrt(1 + x * x) end
      for k = 2, 400 do y[k] = y[k - 1] - 0.5 * bend(y[k - 1] + u[k - 1]^3) + e[k] end
      local train, test = identify.data{u = u, y = y, Ts = 0.5}:split(0.75)
      local m = identify.gaussian_process(train, {regressors = "y(k-1), u(k-1)", approximation = "vfe", inducing = 25,
                                                  starts = 1, refined = 1, iterations = 30})
      print(m.type, #m:inducing(), m.report.samples, identify.metrics(test.y, m:simulate(test)).FIT > 80)
      local mean, variance = m:uncertain(test)
      print(#mean, variance[20] > 0)
      m:save "sparse.yaml"
      local back = identify.load "sparse.yaml"
      print(back:simulate(test) == m:simulate(test), back:log_likelihood() == m:log_likelihood())
      local more, from_file = m:add(test), back:add(test)
      print(more.report.samples, pl.max(pl.abs(more:simulate(test) - from_file:simulate(test))) < 1e-6)
      print(select(2, pcall(function() back:gradient() end))))lua"),
      ::testing::AllOf(HasSubstr("gaussian_process\t25\t299.0\ttrue\n100\ttrue\ntrue\ttrue\n398.0\ttrue\n"),
                       HasSubstr("the gradient of a sparse process needs its data, which a model file does not hold")));
  const auto said = [&](const std::string& script) { return complaint(seven_points + script); };
  EXPECT_THAT(said("gp(X, y, {approximation = 'dtc'})"), HasSubstr("'approximation' must be subset, fitc or vfe"));
  EXPECT_THAT(said("gp(X, y, {inducing = 5})"), HasSubstr("'inducing' is for approximation = \"fitc\" or \"vfe\""));
  EXPECT_THAT(said("gp(X, y, {approximation = 'fitc', points = 5})"),
              HasSubstr("'points' is for approximation = \"subset\"; all rows are seen through the inducing inputs"));
  EXPECT_THAT(said("m:inducing()"), HasSubstr("this process knows its points themselves; approximation = \"fitc\" or "
                                              "\"vfe\" has inducing inputs"));
  EXPECT_THAT(said("gp(X, y, {approximation = 'fitc', inducing = {{1, 2, 3}}})"),
              HasSubstr("the inducing inputs have 3 columns, the data 2 inputs"));
}

TEST_F(Identification, SaysWhatIsWrongWithGivenHyperparameters) {
  const auto said = [&](const std::string& script) { return complaint(seven_points + script); };
  EXPECT_THAT(said("gp(X, y, {hyperparameters = {w1 = 1, v1 = 1, v0 = 1}})"),
              HasSubstr("'hyperparameters' lack 'w2': 'se_ard' of 2 regressors has w1, w2, v1, v0"));
  EXPECT_THAT(said("gp(X, y, {hyperparameters = {w1 = 1, w2 = 1, w3 = 1, v1 = 1, v0 = 1}})"),
              HasSubstr("there is no hyperparameter 'w3': 'se_ard' of 2 regressors has w1, w2, v1, v0"));
  EXPECT_THAT(said("gp(X, y, {hyperparameters = 3})"),
              HasSubstr("'hyperparameters' must be a table of names and numbers, here is 3"));
  EXPECT_THAT(said("gp(X, {1, 2})"), HasSubstr("X has 7 rows and y 2; they must agree"));
  EXPECT_THAT(said("gp(3, y)"), HasSubstr("'data' must be a data set, or X a matrix with y behind it; it is 3"));
  EXPECT_THAT(said("gp(X, y, {regressors = 'u(k)'})"),
              HasSubstr("'regressors' are of a data set; here the columns of X are the regressors"));
  EXPECT_THAT(said("m:predict{1, 2}"), HasSubstr("X has 1 column, the model 2 regressors; each row of X is a point"));
  EXPECT_THAT(said("m:gradient(2)"), HasSubstr("'output' must be a whole number from 1 to 1, it is 2"));
  EXPECT_THAT(said("gp(X, y, {iterations = -1})"), HasSubstr("'iterations' must be 0 or more"));
  EXPECT_THAT(said("local d = pl.identify.data{u = y, y = y, Ts = 1}\n"
                   "pl.identify.local_models(d, {regressors = 'u(k)', models = 2}):gradient()"),
              HasSubstr("only a gaussian_process has a likelihood, this is a local_model_network"));
}

// One start: of several, the thread that tells may get none when the machine is busy.
TEST_F(Identification, TellsTheProgressOfAFitUntilSomethingIsPrinted) {
  std::vector<double> told;
  ScriptOptions watched;
  std::ostringstream output;
  watched.output = &output;
  watched.progress = [&](const std::string& diagram, double fraction) {
    EXPECT_EQ(diagram, "");
    told.push_back(fraction);
  };
  EXPECT_EQ(run_script_text("local I = require('plantloop').identify\n"
                            "local d = I.data{u = I.prbs{bits = 6}, y = I.prbs{bits = 6}, Ts = 1}\n"
                            "I.mlp(d, {regressors = 'u(k-1)', hidden = 2, starts = 1, iterations = 20})\n"
                            "print 'done'\n",
                            "fit.lua", {}, watched),
            script_done);
  ASSERT_GT(told.size(), 3U);
  EXPECT_EQ(told.back(), 1);
  EXPECT_LT(*std::max_element(told.begin(), told.end() - 1), 1);
  EXPECT_GT(told[told.size() - 2], told.front());
}

// A slow state at the start that noise hides: a model of order 2 that is known exactly, and a record that begins far
// from rest.
TEST_F(Identification, EstimatesTheStartOfAFreeRunFromTheFirstSamplesAlone) {
  EXPECT_EQ(printed("local I = pl.identify\n"
                    "local u = I.staircase{samples = 400, hold = 20, lower = -1, upper = 1, seed = 2}\n"
                    "local function record(first, deviation)\n"
                    "  local y = pl.zeros(400)\n"
                    "  y[1], y[2] = first, first\n"
                    "  for k = 3, 400 do y[k] = 1.94 * y[k - 1] - 0.9408 * y[k - 2] + 0.0008 * u[k - 1] end\n"
                    "  return y + deviation * I.white_noise{samples = 400, deviation = 1, seed = 3}, y\n"
                    "end\n"
                    "local exact = record(0, 0)\n"
                    "local m = I.arx(I.data{u = u, y = exact, Ts = 1}, {na = 2, nb = 1})\n"
                    "local s = I.state_space(I.data{u = u, y = exact, Ts = 1}, {order = 2})\n"
                    "local clean = record(3, 0)\n"
                    "local function error_of(model, y, truth, options)\n"
                    "  return I.metrics(truth, model:simulate(I.data{u = u, y = y, Ts = 1}, options)).RMSE\n"
                    "end\n"
                    "local few = {start = 'estimated', samples = 30}\n"
                    "print(error_of(m, clean, clean, few) < 1e-8, error_of(s, clean, clean, few) < 1e-6)\n"
                    "local noisy, truth = record(3, 0.05)\n"
                    "print(error_of(m, noisy, truth, few) < 0.2 * error_of(m, noisy, truth))\n"
                    // What comes after the first samples is not seen.
                    "local later = noisy:copy()\n"
                    "for k = 31, 400 do later[k] = 7 end\n"
                    "print(error_of(m, later, truth, few) == error_of(m, noisy, truth, few),\n"
                    "      error_of(s, later, truth, few) == error_of(s, noisy, truth, few))"),
            "true\ttrue\ntrue\ntrue\ttrue");
  const std::string model =
      "local d = pl.identify.data{u = pl.linspace(0, 1, 20)^2, y = pl.linspace(0, 1, 20), Ts = 1}\n"
      "local m = pl.identify.arx(d, {na = 1, nb = 1})\n";
  EXPECT_THAT(complaint(model + "m:simulate(d, {start = 'first'})"),
              HasSubstr("'start' must be measured, estimated or zero"));
  EXPECT_THAT(complaint(model + "m:simulate(d, {start = 'estimated', samples = 0})"),
              HasSubstr("'samples' must be 1 or more"));
}

// A file named on the command line is the user's choice, wherever it lies; nothing else outside is read.
TEST_F(Identification, ReadsTheFilesOfTheCommandLine) {
  const std::string path = (outside() / "rig.csv").string();
  write(path, "time,u,y\n0,1,2\n1,2,3\n2,3,4\n");
  const std::string script = "local pl = require 'plantloop'; print(pl.identify.read(arg[1]).samples)";
  EXPECT_EQ(run(script, {path}).output, "3\n");
  EXPECT_EQ(run(script, {"../rig.csv"}).output, "3\n");
  EXPECT_EQ(run("print(require('plantloop').identify.read('../rig.csv').samples)", {"test=../rig.csv"}).output, "3\n");
  EXPECT_NE(run("require('plantloop').identify.read('" + path + "')", {"other.csv"})
                .messages.find("it lies outside of the project"),
            std::string::npos);
}

TEST_F(Identification, FindsOrdersAndDelays) {
  EXPECT_EQ(with_data(R"lua(
      local noisy = identify.data{u = u, y = y + identify.white_noise{samples = #y, deviation = 0.02, seed = 3}, Ts = 0.1}
      local list = identify.order_table(noisy, {na = {1, 3}, nb = {1, 2}, delay = {0, 2}})
      local delays, errors = identify.delay_table(noisy, {order = 1, delay = {0, 3}})
      print(#list, list.best.simulated.delay, delays[errors:argmin()]))lua"),
            "18\t0\t0.0");
}

TEST_F(Identification, PolynomialModelsFindTheirTerms) {
  EXPECT_EQ(printed(R"lua(local identify = pl.identify
      local u, y = identify.staircase{samples = 400, hold = {2, 5}, seed = 2}, pl.zeros(400)
      for k = 3, 400 do y[k] = 0.5 * y[k - 1] + 0.4 * u[k - 2] ^ 2 end
      local m = identify.polynomial(identify.data{u = u, y = y, Ts = 1},
                                    {regressors = "y(k-1), u(k-1..2)", degree = 2, normalise = false, most_terms = 4})
      table.sort(m.names)
      print(m.names[1] == 'u(k-2)^2' or m.names[2] == 'u(k-2)^2', m.longest_lag))lua"),
            "true\t2");
}

TEST_F(Identification, SaysWhatIsWrongInTheUsersWords) {
  EXPECT_THAT(complaint("pl.identify.data{y = {1, 2}}"), HasSubstr("the data need 'Ts', the sampling time in s"));
  const std::string data = "local data = pl.identify.data{u = pl.ones(20), y = pl.ones(20), Ts = 1}; ";
  EXPECT_THAT(complaint(data + "pl.identify.arx(data, {nba = 1})"),
              HasSubstr("the options of arx: there is no 'nba'; did you mean 'na'?"));
  EXPECT_THAT(complaint(data + "pl.identify.arx(data, {nb = 30})"),
              HasSubstr("31 parameters cannot be estimated from 20 samples"));
  EXPECT_THAT(complaint(data + "print(data.sample)"), HasSubstr("a data set has no 'sample'; did you mean 'samples'?"));
  EXPECT_THAT(complaint("pl.identify.arx({})"), HasSubstr("'data' must be a data set, it is a table"));
  EXPECT_THAT(complaint(data + "pl.identify.regression(data, {regressors = 'y(k-1), v(k-1)'})"),
              HasSubstr("regressors, character 9: there is no signal 'v'"));
  write("m.yaml", "plantloop_model: 1\ntype: linear_model\nTs: 0.1\n");
  EXPECT_THAT(complaint("pl.identify.load 'm.yaml'"), HasSubstr("m.yaml:1:1: the key 'structure' is missing"));
}

TEST_F(Identification, RefusesOptionsThatMakeNoSense) {
  const auto said = [&](const std::string& call, const std::string& words) {
    EXPECT_EQ(with_data("print(select(2, pcall(function() return " + call + " end)))").find(words) != std::string::npos,
              true)
        << call << "\n"
        << with_data("print(select(2, pcall(function() return " + call + " end)))");
  };
  said("identify.oe(data, {nb = 1, nf = 1, iterations = -3})", "the number of iterations is -3; it must be 0 or more");
  said("identify.polynomial(data, {regressors = 'y(k-1), u(k-1)', iterations = -1})",
       "the number of iterations is -1; it must be 0 or more");
  said("identify.polynomial(data, {regressors = 'y(k-1), u(k-1)', validation = 2})",
       "'validation' is the part of the record that is held back, greater than 0 and less than 1; it is 2");
  said("identify.mlp(data, {regressors = 'y(k-1), u(k-1)', patience = -1})",
       "the patience is a number of iterations, 1 or more; it is -1");
  said("identify.mlp(data, {regressors = 'y(k-1), u(k-1)', seed = -1})",
       "'seed' must be a whole number, 0 or more, it is");
  said("identify.rbf_network(data, {regressors = 'y(k-1), u(k-1)', tolerance = -1})",
       "the tolerance is the part of the variance that may stay unexplained, 0 or more and less than 1; it is -1");
  said("identify.periodogram(data.y, 0)", "the sampling time of a periodogram must be greater than 0 s, it is 0 s");
  said("identify.spectral(data, {window = 'hanning'})",
       "there is no window 'hanning'; there are hamming, hann, bartlett, parzen");
  const std::string prune =
      "identify.mlp(data, {regressors = 'y(k-1), u(k-1)', hidden = 2, starts = 1, iterations = 2}):prune";
  said(prune + "(data, {least = -1})", "'least' is the number of weights at which pruning ends, 1 or more; it is -1");
  said(prune + "(data, {decay = -1})", "the weight decay is -1; it must be 0 or greater");
}

// Of a script's limit of time every thread of a fit knows, in the midst of an iteration too.
TEST_F(Identification, AFitEndsWithTheScriptsTime) {
  options.time_limit = 1;
  const ScriptResult result = run(R"lua(local pl = require "plantloop"
      local identify = pl.identify
      local u = identify.white_noise{samples = 20000, seed = 1}
      local data = identify.data{u = u, y = pl.sin(u), Ts = 1}
      pcall(identify.mlp, data, {regressors = "y(k-1..3), u(k-1..3)", hidden = 150})
      print "went on")lua");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages,
              HasSubstr("stopped: the script ran for 1 s, its limit (--max-time SECONDS gives it more)"));
  EXPECT_EQ(result.output.find("went on"), std::string::npos);
  EXPECT_LT(result.seconds, 20);
}

TEST_F(Identification, AdvisesOnData) {
  EXPECT_THAT(with_data("for _, line in ipairs(data:advice()) do print(line) end"),
              HasSubstr("'u' acts on 'level' after about 1 sample"));
}

}  // namespace
}  // namespace plantloop
