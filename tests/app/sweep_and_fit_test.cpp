// plantloop sweep and plantloop fit: tables, reports, exit statuses, and what is said when something is wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* lag = R"(plantloop: 1
parameters: {k: 2, tau: 1, n: 1}
blocks:
  x: {type: first_order, in: 1, k: k, tau: tau}
  v: {type: integrator, in: ones(n)}
simulation: {stop: 50, rtol: 1e-9}
record: [x, v]
)";

TEST(SweepCommand, WritesARowForEachPoint) {
  const Workplace place;
  place.write("lag.yaml", lag);
  const Outcome o = place.run("sweep lag.yaml --grid k=1,2 --list tau=0.5:1:2 --measure max:x");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, StartsWith("point,k,tau,max(x)\n1,1,0.5,"));
  EXPECT_THAT(o.out, AllOf(HasSubstr("\n2,1,1,"), HasSubstr("\n3,2,0.5,"), HasSubstr("\n4,2,1,")));
}

TEST(SweepCommand, GivesTheSameBytesForAnyNumberOfThreads) {
  const Workplace place;
  place.write("lag.yaml", lag);
  const std::string arguments = "sweep lag.yaml --random 'k=normal(1, 0.2)' --draws 40 --seed 3 --grid n=1,2";
  const Outcome one = place.run(arguments + " --threads 1"), many = place.run(arguments + " --threads 4");
  EXPECT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(one.out, many.out);
  EXPECT_THAT(one.out, StartsWith("point,n,k,x,v\n"));
  for (const char* number : {"0", "1", "8"}) {
    setenv("LP_NUM_THREADS", number, 1);
    EXPECT_EQ(place.run(arguments).out, one.out) << number;
    unsetenv("LP_NUM_THREADS");
  }
}

TEST(SweepCommand, TellsWhichPointsFailedAndKeepsTheOthers) {
  const Workplace place;
  place.write("lag.yaml", lag);
  const Outcome o = place.run("sweep lag.yaml --grid tau=-1,1 --measure final:x --out table.csv");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.err, AllOf(HasSubstr("point 1 (tau = -1) failed: "), HasSubstr("it must be at least 1e-09"),
                           HasSubstr("1 of 2 points failed")));
  EXPECT_THAT(place.read("table.csv"), AllOf(HasSubstr("\n1,-1,nan\n"), HasSubstr("\n2,1,1.99999")));
}

TEST(SweepCommand, SaysWhatIsWrong) {
  const Workplace place;
  place.write("lag.yaml", lag);
  const auto said = [&](const std::string& arguments) {
    const Outcome o = place.run("sweep lag.yaml " + arguments);
    EXPECT_EQ(o.status, 2) << arguments;
    return o.err;
  };
  EXPECT_THAT(said("--grid k"), HasSubstr("--grid k: it must be path=values, as in --grid k=1,2,5 or --grid k=0:1:11"));
  EXPECT_THAT(said("--random k=1"), HasSubstr("there are: uniform(lower, upper), log_uniform(lower, upper), normal"));
  EXPECT_THAT(said("--grid k=1 --measure mx:x"), HasSubstr("it must be measure:signal, as in --measure max:x"));
  EXPECT_THAT(said("--grid k=1 --measure max:y"), HasSubstr("'y' is not recorded"));
  EXPECT_THAT(said("--grid q=1"), HasSubstr("q"));
  EXPECT_THAT(said(""), HasSubstr("the sweep has no parameters"));
  EXPECT_THAT(said("--grid k=1 --out a.txt"), HasSubstr("--out a.txt: the name must end in .csv"));
}

// x = 3 (1 - exp(-t/0.5)) with a missing value.
constexpr const char* data =
    "time,x\n0.2,0.98903986189108239\n0.5,1.896361676485673\n0.8,\n1,2.5939941502901616\n2,2.945053083333798\n";

TEST(FitCommand, TakesSeveralExperimentsWithValuesOfTheirOwn) {
  const Workplace place;
  place.write("line.yaml",
              "plantloop: 1\nparameters: {a: 0, b: 0, c: 0}\nblocks: {y: a + b*time + c}\nsimulation: {stop: 5}\n");
  place.write("one.csv", "time,y\n0,1\n1,2.5\n");
  place.write("two.csv", "time,y\n2,7\n3,9\n4,9.2\n");
  const std::string arguments = "fit line.yaml one.csv two.csv --parameter a --parameter b ";
  const Outcome o = place.run(arguments + "--set-in 2:c=5 --out fit.csv");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, AllOf(HasSubstr("0.79"), HasSubstr("experiment 1: 'y' is met within"),
                           HasSubstr("experiment 2: 'y' is met within")));
  EXPECT_THAT(place.read("fit.csv"),
              AllOf(StartsWith("experiment,time,y,y fitted\n1,0,1,"), HasSubstr("\n2,4,9.1999999999999993,9.32")));
  EXPECT_THAT(place.run(arguments + "--set-in 3:c=5").err,
              HasSubstr("--set-in 3:c=5: it must be N:path=expression, where N is the number of a data file, 1 to 2"));
}

TEST(FitCommand, TellsEstimatesAndWritesThem) {
  const Workplace place;
  place.write("lag.yaml", lag);
  place.write("data.csv", data);
  const Outcome o =
      place.run("fit lag.yaml data.csv --parameter k --parameter tau=0.8 --bound tau=0.1:5 --out fit.json");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, AllOf(StartsWith("fitted after "), HasSubstr("derivatives: exact\n"), HasSubstr("95 % interval"),
                           HasSubstr("'x' is met within"), HasSubstr("of 4 values")));
  EXPECT_THAT(place.read("fit.json"), AllOf(HasSubstr("\"converged\": true"), HasSubstr("\"value\": 0.5"),
                                            HasSubstr("\"value\": 3.0"), HasSubstr("\"covariance\"")));
  EXPECT_EQ(place.run("fit lag.yaml data.csv --parameter k --out fitted.csv").status, 0);
  EXPECT_THAT(place.read("fitted.csv"), StartsWith("time,x,x fitted\n0.2"));
}

TEST(FitCommand, SaysWhatIsWrong) {
  const Workplace place;
  place.write("lag.yaml", lag);
  place.write("data.csv", data);
  place.write("text.csv", "time,x\n1,2\n2,much\n");
  const auto said = [&](const std::string& arguments) {
    const Outcome o = place.run("fit lag.yaml " + arguments);
    EXPECT_EQ(o.status, 2) << arguments;
    return o.err;
  };
  EXPECT_THAT(said("data.csv --parameter k=much"),
              HasSubstr("--parameter k=much: it must be path or path=start, as in --parameter tau=0.5"));
  EXPECT_THAT(said("data.csv --parameter k --bound tau=0:1"), HasSubstr("'tau' is not among the fitted parameters"));
  EXPECT_THAT(said("data.csv --parameter k --bound k=0"), HasSubstr("it must be path=lower:upper"));
  EXPECT_THAT(said("data.csv --parameter n"), HasSubstr("'n' shapes the diagram"));
  EXPECT_THAT(said("data.csv --parameter k --signal x=y"), HasSubstr("the data data.csv have no column 'y'"));
  EXPECT_THAT(said("data.csv --parameter k --weight y=1"), HasSubstr("it must be signal=number"));
  EXPECT_THAT(said("text.csv --parameter k"), HasSubstr("text.csv:3:3: 'much' is no number"));
  place.write("late.csv", "t,x\n1,2\n2,3\n");
  EXPECT_THAT(said("late.csv --parameter k"), HasSubstr("the data late.csv have no column 'time'"));
  EXPECT_THAT(said("none.csv --parameter k"), HasSubstr("cannot read 'none.csv'"));
}

}  // namespace
}  // namespace plantloop::testing_program
