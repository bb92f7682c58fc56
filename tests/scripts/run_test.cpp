// Diagrams and runs from scripts.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Runs : public Workshop {
 protected:
  Runs() { write_lag(); }
};

TEST_F(Runs, GiveColumnsByNameAndTime) {
  EXPECT_EQ(printed("local run = pl.load('lag.yaml'):run(); print(run.time[1], run.time[#run.time], run['u'][1], "
                    "#run.y == #run.time)"),
            "0.0\t5.0\t0.0\ttrue");
  // y(5) = 1 - exp(-4/2); rtol 1e-9 leaves 1e-7 ample room.
  EXPECT_EQ(
      printed("local run = pl.load('lag.yaml'):run(); print(math.abs(run.y[#run.y] - (1 - math.exp(-2))) < 1e-7)"),
      "true");
}

TEST_F(Runs, TakeParametersAndSettings) {
  EXPECT_EQ(
      printed("local lag = pl.load 'lag.yaml'\n"
              "local run = lag:run{set = {tau = 1, ['u.after'] = '2*tau'}, stop = 3, solver = 'rk4', step = 0.01}\n"
              "print(math.abs(run.y[#run.y] - 2*(1 - math.exp(-2))) < 1e-6, run:statistics().steps >= 300)"),
      "true\ttrue");
  EXPECT_EQ(printed("local lag = pl.load('lag.yaml'):with{tau = 1}\n"
                    "local a = lag:run{}.y; local b = lag:run{set = {u = {after = 3}}}.y\n"
                    "print(math.abs(b[#b] / a[#a] - 3) < 1e-6)"),
            "true");
}

TEST_F(Runs, NameTheColumnsWhenOneIsUnknown) {
  EXPECT_EQ(complaint("print(pl.load('lag.yaml'):run().yy)"),
            "experiment.lua:1: the run has no column 'yy'; did you mean 'y'?  it has: time, u, y, save");
}

TEST_F(Runs, ReachAColumnAndAMethodOfTheSameName) {
  EXPECT_EQ(
      printed(
          "local run = pl.load('lag.yaml'):run(); print(run.save[1], run:save('out/lag.csv'), run.save == 2*run.y)"),
      "0.0\tout/lag.csv\ttrue");
  EXPECT_THAT(read("out/lag.csv"), StartsWith("time,u,y,save\n"));
}

TEST_F(Runs, WriteFilesByTheirEnding) {
  EXPECT_EQ(printed("local r = pl.load('lag.yaml'):run(); print(r:csv('a.csv'), r:save('b/c.json'), r:save('d.npz'))"),
            "a.csv\tb/c.json\td.npz");
  EXPECT_THAT(read("b/c.json"), HasSubstr("\"y\""));
  EXPECT_THAT(read("d.npz"), StartsWith("PK"));
  EXPECT_THAT(complaint("pl.load('lag.yaml'):run():save('x.xls')"), HasSubstr("must end in .csv, .json or .npz"));
}

TEST_F(Runs, AreMeasured) {
  // Between rows, 0.06 s apart, a column is a straight line: off by at most h^2 y''/8 = 5e-5.
  EXPECT_EQ(
      printed(
          "local r = pl.load('lag.yaml'):run{stop = 30}\n"
          "print(math.abs(r:measure('rise_time', 'y', {step = {at = 1, from = 0, to = 1}}) - 2*math.log(9)) < 1e-3)\n"
          "print(r:measure('overshoot', 'y', {step = {at = 1, to = 1}}), math.abs(r:at('y', 3) - (1 - math.exp(-1))) < "
          "1e-4)\n"
          "print(r:at('u', 1), r:at('u', 1, 'left'), #r:at('y', {2, 3}), r:unit('y'), r:unit('time'))"),
      "true\n0.0\ttrue\n1.0\t0.0\t2\tm\ts");
  EXPECT_THAT(complaint("pl.load('lag.yaml'):run():measure('overshot', 'y')"),
              HasSubstr("measure: there is no measure 'overshot'; did you mean 'overshoot'?"));
  EXPECT_THAT(complaint("pl.load('lag.yaml'):run():at('y', 7)"), HasSubstr("7 s lies outside of the run"));
}

TEST_F(Runs, TellTheVerdicts) {
  EXPECT_EQ(printed("for _, v in ipairs(pl.load('lag.yaml'):run():verdicts()) do print(v.met) end"), "true\nfalse");
}

TEST_F(Runs, CannotBeChanged) {
  EXPECT_THAT(complaint("local r = pl.load('lag.yaml'):run(); r.y = 1"), HasSubstr("it cannot be changed"));
  EXPECT_THAT(complaint("local r = pl.load('lag.yaml'):run(); r.y[1] = 1"), HasSubstr("these numbers are fixed"));
  EXPECT_EQ(printed("local y = pl.load('lag.yaml'):run().y:copy(); y[1] = 5; print(y[1])"), "5.0");
}

TEST_F(Runs, OfAVectorSignalGiveAMatrix) {
  write("vector.yaml",
        "plantloop: 1\nblocks:\n  x: {type: integrator, in: [1, 2], initial: [0, 0]}\nsimulation: {stop: 1}\n");
  EXPECT_EQ(printed("local r = pl.load('vector.yaml'):run(); print(r.x:columns(), r.x[#r.x], r['x.2'][#r.time])"),
            "2\t[1, 2]\t2.0");
}

TEST_F(Runs, SayWhatIsWrongWithADiagramInFull) {
  write("wrong.yaml", "plantloop: 1\nblocks:\n  y: {type: first_oder, in: 1}\nsimulation: {stop: 1}\n");
  const ScriptResult result = run("local pl = require 'plantloop'\npl.load('wrong.yaml'):run()");
  EXPECT_EQ(result.status, script_input_wrong);
  EXPECT_THAT(result.messages, HasSubstr("wrong.yaml:3:13: error: "));
  EXPECT_THAT(result.messages, HasSubstr("did you mean 'first_order'?"));
  EXPECT_EQ(run("local pl = require 'plantloop'; pl.load 'nothing.yaml'").status, script_input_wrong);
}

TEST_F(Runs, SayWhichSettingIsUnknown) {
  const ScriptResult result = run("local pl = require 'plantloop'; pl.load('lag.yaml'):run{set = {['y.taw'] = 1}}");
  EXPECT_EQ(result.status, script_input_wrong);
  EXPECT_THAT(result.messages, HasSubstr("taw"));
  EXPECT_THAT(complaint("pl.load('lag.yaml'):run{stp = 3}"), HasSubstr("there is no 'stp'; did you mean 'stop'?"));
  EXPECT_THAT(complaint("pl.load('lag.yaml').run{stop = 3}"), HasSubstr("it is called with ':'"));
}

TEST_F(Runs, HandARunErrorToTheScript) {
  write("blows.yaml", "plantloop: 1\nblocks:\n  x: {type: integrator, in: x^2, initial: 1}\nsimulation: {stop: 2}\n");
  EXPECT_EQ(
      printed("local ok, message = pcall(function() return pl.load('blows.yaml'):run() end); print(ok, #message > 0)"),
      "false\ttrue");
  EXPECT_EQ(run("require('plantloop').load('blows.yaml'):run()").status, script_failed);
}

TEST_F(Runs, CheckWithoutRunning) {
  EXPECT_EQ(printed("local ok, text = pl.load('lag.yaml'):check{set = {tau = -1}}; print(ok, #text > 0)"),
            "false\ttrue");
  EXPECT_EQ(printed("local d = pl.load('lag.yaml'); print(d:check(), d.title, d.path, d.parameters.tau)"),
            "true\tA lag\tlag.yaml\t2");
}

TEST_F(Runs, OfADiagramInTheScript) {
  EXPECT_EQ(
      printed(
          "local d = pl.diagram [[\nplantloop: 1\nblocks: {x: {type: integrator, in: 3}}\nsimulation: {stop: 2}\n]]\n"
          "local r = d:run(); print(r.x[#r.x])"),
      "6.0");
}

TEST_F(Runs, S14CheckpointsGoOnWithTheSameBits) {
  EXPECT_EQ(printed("local d = require('plantloop').load 'lag.yaml'\n"
                    "local whole = d:run{stop = 4, save_at = 2, save = 'half.json'}\n"
                    "local rest = d:run{stop = 4, from = 'half.json'}\n"
                    "print(rest.time[1], rest.y[#rest.y] == whole.y[#whole.y])"),
            "2.0\ttrue");
}

TEST_F(Runs, S14CheckpointsThatDoNotFitAreRefused) {
  const std::string other =
      "local pl = require 'plantloop'\npl.load 'lag.yaml':run{stop = 2, save = 'half.json'}\n"
      "local d = pl.diagram [[\nplantloop: 1\nblocks: {x: {type: integrator, in: 3}}\nsimulation: {stop: 4}\n]]\n";
  EXPECT_THAT(run(other + "d:run{from = 'half.json'}").messages,
              testing::AllOf(HasSubstr("the checkpoint is of another diagram, or of this one before it changed"),
                             HasSubstr("it does not have: x")));
  EXPECT_EQ(printed(other + "print(#d:run{from = 'half.json', partial = true}.time > 0)"), "true");
  write("half.json", "{");
  EXPECT_THAT(complaint("require('plantloop').load 'lag.yaml':run{from = 'half.json'}"),
              HasSubstr("cannot read 'half.json': it is no checkpoint of a run"));
}

TEST_F(Runs, EndWhenTheScriptIsCancelled) {
  std::atomic<bool> cancel{true};
  options.cancel = &cancel;
  const ScriptResult result = run("require('plantloop').load('lag.yaml'):run{stop = 1e6}");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, HasSubstr("stopped on request"));
}

TEST_F(Runs, EndAtTheScriptsTimeLimit) {
  options.time_limit = 0.3;
  const ScriptResult result =
      run("local d = require('plantloop').load 'lag.yaml'\npcall(d.run, d, {stop = 1e9, solver = 'rk4', step = 1e-3, "
          "output_interval = 1e6})\nprint 'on'");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(result.messages, HasSubstr("the script ran for 0.3 s, its limit"));
  EXPECT_LT(result.seconds, 5);
}

}  // namespace
}  // namespace plantloop
