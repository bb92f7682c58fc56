// S14 at the command line: save points, runs that go on, forks, and checkpoints that do not fit; what a failed run
// leaves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* loop = R"(plantloop: 1
parameters: {k: 2}
blocks:
  z: {type: zero_order_hold, in: x, rate: 0.1}
  n: {type: unit_delay, in: n + 1, rate: 0.1}
  late: {type: transport_delay, in: x, delay: 0.25}
  x: {type: integrator, in: 1 - k*z - 0.1*late, initial: 0.5}
simulation: {stop: 2, max_step: 0.05}
record: [x, z, n, late]
)";

class S14Checkpoint : public testing::Test {
 protected:
  S14Checkpoint() { place_.write("loop.yaml", loop); }
  void save_half() {
    const Outcome o = place_.run("run loop.yaml --stop 1 --save half.json --out first.csv");
    ASSERT_EQ(o.status, 0) << o.err;
  }
  // What `run --from half.json` complains about.
  std::string complaint(const std::string& arguments = "") {
    const Outcome o = place_.run("run loop.yaml --from half.json --out rest.csv " + arguments);
    EXPECT_EQ(o.status, 2);
    EXPECT_EQ(o.out, "");
    return o.err;
  }
  void replace(const std::string& what, const std::string& by) {
    std::string text = place_.read("half.json");
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos);
    place_.write("half.json", text.replace(at, what.size(), by));
  }
  Workplace place_;
};

TEST_F(S14Checkpoint, GoesOnWithTheBytesOfTheWholeRun) {
  save_half();
  ASSERT_EQ(place_.run("run loop.yaml --save-at 1 --save any.json --out whole.csv").status, 0);
  ASSERT_EQ(place_.run("run loop.yaml --from half.json --out rest.csv").status, 0);
  const std::string whole = place_.read("whole.csv"), rest = place_.read("rest.csv");
  // A hit stands at 1 s: its row is the last of the first run and the first of the rest.
  const std::size_t from = whole.find("\n1,"), also = rest.find("\n1,");
  ASSERT_NE(from, std::string::npos);
  ASSERT_NE(also, std::string::npos);
  EXPECT_EQ(whole.substr(from), rest.substr(also));
}

TEST_F(S14Checkpoint, IsForkedWithOtherParameters) {
  save_half();
  ASSERT_EQ(place_.run("run loop.yaml --from half.json --set k=0 --set late.delay=0.25 --out rest.csv").status, 0);
  ASSERT_EQ(place_.run("run loop.yaml --from half.json --out same.csv").status, 0);
  const std::string fork = place_.read("rest.csv"), same = place_.read("same.csv");
  const auto line = [](const std::string& text, int number) {
    std::size_t at = 0;
    while (number-- > 0) at = text.find('\n', at) + 1;
    return text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(line(fork, 1), line(same, 1));  // both begin where the first run ended
  EXPECT_NE(fork.substr(fork.find("\n2,")), same.substr(same.find("\n2,")));
}

TEST_F(S14Checkpoint, OfAnotherStructureIsRefusedWithWhatDiffers) {
  save_half();
  std::string changed = loop;
  changed.insert(changed.find("simulation"), "  v: {type: first_order, in: x, tau: 1}\n");
  changed.replace(changed.find("  n: {"), 6, "  m: {");
  changed.replace(changed.find("in: n + 1"), 9, "in: m + 1");
  changed.replace(changed.find("z, n, late"), 10, "z, m, late");
  place_.write("loop.yaml", changed);
  EXPECT_EQ(complaint(),
            "error: the checkpoint is of another diagram, or of this one before it changed\n"
            "  it does not have: v, m\n"
            "  only it has: n\n"
            "  with 'partial' the values of equal paths are taken, and all else starts anew\n");
  const Outcome o = place_.run("run loop.yaml --from half.json --partial --out rest.csv");
  EXPECT_EQ(o.status, 0) << o.err;
  // x goes on, m begins.
  const std::string first = place_.read("first.csv"), rest = place_.read("rest.csv");
  const std::string x = first.substr(first.rfind("\n1,") + 3);
  EXPECT_THAT(rest.substr(rest.find("\n1,") + 3), StartsWith(x.substr(0, x.find(',')) + ","));
}

TEST_F(S14Checkpoint, ThatIsDamagedIsRefused) {
  save_half();
  const std::string whole = place_.read("half.json");
  place_.write("half.json", whole.substr(0, whole.size() / 2));
  EXPECT_EQ(complaint(), "plantloop: cannot read 'half.json': it is no checkpoint of a run\n");
  place_.write("half.json", "{\"a\": 1}\n");
  EXPECT_EQ(complaint(), "plantloop: cannot read 'half.json': it is no checkpoint of a run\n");
  place_.write("half.json", whole);
  replace("\"time\": 1.0", "\"time\": 1.5");
  EXPECT_EQ(complaint(), "plantloop: cannot read 'half.json': it is damaged: its checksum is of other contents\n");
  place_.write("half.json", whole);
  replace("\"next_hit\"", "\"next_hot\"");
  EXPECT_EQ(complaint(), "plantloop: cannot read 'half.json': it is damaged: its checksum is of other contents\n");
  place_.write("half.json", whole);
  replace("\"checksum\"", "\"checksun\"");
  EXPECT_EQ(
      complaint(),
      "plantloop: cannot read 'half.json': it is damaged: a part of the checkpoint is missing or of another kind\n");
}

TEST_F(S14Checkpoint, OfAnotherVersionIsRefused) {
  save_half();
  replace("\"plantloop_checkpoint\": 3", "\"plantloop_checkpoint\": 7");
  EXPECT_EQ(
      complaint(),
      "plantloop: cannot read 'half.json': it was written by another version: its format is 7, this one reads 3\n");
}

TEST_F(S14Checkpoint, ThatIsNotThereOrTooLateIsAnError) {
  EXPECT_THAT(complaint(), StartsWith("plantloop: cannot read 'half.json': "));
  save_half();
  EXPECT_EQ(complaint("--stop 1"), "error: the run stops at 1 s, which is not after the checkpoint's time, 1 s\n");
  EXPECT_THAT(complaint("--save-at 0.5 --save x.json"),
              HasSubstr("error: the save point 0.5 s lies outside of the run, which goes from 1 s to 2 s"));
}

// The result that stood there before stays.
TEST(RunCommand, KeepsWhatAFailedRunRecorded) {
  Workplace place;
  place.write("fails.yaml",
              "plantloop: 1\n"
              "blocks:\n"
              "  x: {type: integrator, in: 1}\n"
              "  limit: {type: assertion, in: 1.5 - x, message: too high}\n"
              "simulation: {stop: 10, max_step: 0.25}\nrecord: [x]\n");
  place.write("result.csv", "before\n");
  const Outcome o = place.run("run fails.yaml --out result.csv");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.err, HasSubstr("what was recorded until then is in 'result.partial.csv'"));
  EXPECT_EQ(place.read("result.csv"), "before\n");
  const std::string rows = place.read("result.partial.csv");
  EXPECT_THAT(rows, StartsWith("time,x\n0,0\n"));
  // The last row is where the assertion failed.
  const std::string last = rows.substr(rows.rfind('\n', rows.size() - 2) + 1);
  EXPECT_NEAR(std::stod(last), 1.5, 1e-9);
}

}  // namespace
}  // namespace plantloop::testing_program
