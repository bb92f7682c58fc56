// Scripts that try to go on forever or to take all memory: each ends soon, with status 1 and a message.

#include <atomic>
#include <thread>

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

struct Bomb {
  const char* name;
  const char* script;
};

class Bombs : public Workshop, public ::testing::WithParamInterface<Bomb> {};

// Under sanitizers everything takes some ten times as long, so the bound is wide: an endless script would take forever.
constexpr double soon = 20;  // s

TEST_P(Bombs, EndSoon) {
  options.time_limit = 0.5;
  options.max_memory = std::size_t{64} << 20;
  const ScriptResult result = run(GetParam().script);
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, AnyOf(HasSubstr("its limit"), HasSubstr("overflow"))) << GetParam().script;
  EXPECT_LT(result.seconds, soon);
  EXPECT_EQ(result.output.find("went on"), std::string::npos);
}

const Bomb bombs[] = {
    {"Loop", "while true do end"},
    {"Goto", "::again:: goto again"},
    {"Repeat", "repeat local x = 1 until false"},
    {"NumericFor", "for i = 1, math.huge do end"},
    {"PcallLoop", "while true do pcall(function() while true do end end) end"},
    {"PcallInPcall", "while true do pcall(pcall, pcall, function() while true do end end) end"},
    {"XpcallLoop", "while true do xpcall(function() while true do end end, function() while true do end end) end"},
    {"HandlerThatFails", "xpcall(function() while true do end end, function(e) error(e) end); print 'went on'"},
    {"GoOnAfterPcall", "pcall(function() while true do end end); print 'went on'"},
    {"Coroutine", "coroutine.wrap(function() while true do end end)()"},
    {"CoroutineSwallowed", "while true do coroutine.resume(coroutine.create(function() while true do end end)) end"},
    {"CoroutinesWithoutEnd", "while true do coroutine.wrap(function() for i = 1, 900 do end end)() end"},
    {"CoroutinePingPong",
     "local co = coroutine.wrap(function() while true do coroutine.yield() end end); while true do co() end"},
    {"CoroutineInCoroutine",
     "local function f() while true do pcall(coroutine.wrap(function() pcall(f) while true do end end)) end end f()"},
    {"HandlerOfTheEnd", "xpcall(function() while true do end end, function() while true do end end)"},
    {"CloseOfTheEnd",
     "coroutine.wrap(function()\n"
     "  local x <close> = setmetatable({}, {__close = function() while true do end end})\n"
     "  while true do end\nend)()"},
    {"CloseOfTheEndByHand",
     "local co = coroutine.create(function()\n"
     "  local x <close> = setmetatable({}, {__close = function() while true do end end})\n"
     "  while true do end\nend)\ncoroutine.resume(co)\ncoroutine.close(co)"},
    {"CloseOfASuspendedCoroutine",
     "local co = coroutine.create(function()\n"
     "  local x <close> = setmetatable({}, {__close = function() while true do end end})\n"
     "  coroutine.yield()\nend)\ncoroutine.resume(co)\ncoroutine.close(co)"},
    {"PcallInACoroutineOfTheEnd",
     "local co = coroutine.wrap(function()\n"
     "  pcall(function() local x <close> = setmetatable({}, {__close = function() while true do end end}); while true "
     "do end end)\n"
     "  while true do end\nend)\nwhile true do pcall(co) end"},
    {"CloseLoop", "local x <close> = setmetatable({}, {__close = function() while true do end end}); error 'x'"},
    {"CloseAfterTheEnd",
     "for i = 1, math.huge do local x <close> = setmetatable({}, {__close = function() while true do end end}) end"},
    {"RecursionWithoutEnd", "local function f() return 1 + f() end f()"},
    {"TailCalls", "local function f() return f() end f()"},
    {"IndexRecursion",
     "local t = setmetatable({}, {}); getmetatable(t).__index = function(t, k) return t[k + 1] end; return t[1]"},
    {"TostringOfError", "error(setmetatable({}, {__tostring = function() while true do end end}))"},
    {"TostringPrint", "print(setmetatable({}, {__tostring = function() while true do end end}))"},
    {"Concatenation", "local s = 'x'; while true do s = s .. s end"},
    {"ConcatenationSwallowed", "local s = 'x'; while true do pcall(function() s = s .. s end) end"},
    {"Rep", "local s = ('x'):rep(1e12)"},
    {"RepMany", "while true do local s = ('x'):rep(2e7) end"},
    {"RepSeparator", "local s = (''):rep(1e12, 'x')"},
    {"RepPcall", "while true do pcall(string.rep, 'x', 1e10) end"},
    {"TableGrows", "local t = {}; while true do t[#t + 1] = {} end"},
    {"TableGrowsSwallowed",
     "local t = {}; while true do pcall(function() while true do t[#t + 1] = {1, 2, 3} end end) end"},
    {"FormatBomb", "local t = {}; while true do t[#t + 1] = ('%099d'):format(#t) end"},
    {"ConcatBomb", "local t = {}; for i = 1, 1e5 do t[i] = ('x'):rep(1000) end; table.concat(t)"},
    {"ConcatOfAnyLength",
     "table.concat(setmetatable({}, {__len = function() return 2^60//1 | 0 end, __index = function() return '' end}))"},
    {"GsubGrows", "local s = 'x'; while true do s = s:gsub('x', 'xxxx') end"},
    {"PatternBomb", "(('a'):rep(40)):find(('a?'):rep(40) .. ('a'):rep(41))"},
    {"PatternMinus", "(('a'):rep(3000)):find('.-.-.-.-.-b')"},
    {"PatternStar", "(('a'):rep(3000)):match('a*a*a*a*a*b')"},
    {"PatternGmatch", "for x in (('a'):rep(2000)):gmatch('.-.-.-.-b') do end"},
    {"PatternGsub", "(('a'):rep(2000)):gsub('.-.-.-.-b', '')"},
    {"PatternSwallowed", "while true do pcall(string.find, ('a'):rep(3000), '.-.-.-.-.-b') end"},
    {"PlainFind", "local a, b = ('a'):rep(2e7), ('a'):rep(1e7) .. 'b'; while true do a:find(b, 1, true) end"},
    {"MoveForever", "table.move({}, 1, math.maxinteger - 1, 2)"},
    {"InsertForever", "table.insert(setmetatable({}, {__len = function() return 1 << 60 end}), 1, 1)"},
    {"RemoveForever", "table.remove(setmetatable({}, {__len = function() return 1 << 60 end}), 1)"},
    {"SortOfAnyLength",
     "table.sort(setmetatable({}, {__len = function() return 1 << 60 end, __index = function() return 1 end}))"},
    {"SortWithALoop", "table.sort({1, 2, 3}, function() while true do end end)"},
    {"SortBadOrder",
     "local t = {}; for i = 1, 3e5 do t[i] = i end; while true do table.sort(t, function() return true end) end"},
    {"PairsForever",
     "for k in pairs(setmetatable({}, {__pairs = function() return function() return 1 end end})) do end"},
    {"IpairsForever", "for i in ipairs(setmetatable({}, {__index = function() return 1 end})) do end"},
    {"PrintForever", "while true do print(('x'):rep(1000)) end"},
    {"VectorTooLarge", "require('plantloop').zeros(1e9)"},
    {"VectorFarTooLarge", "require('plantloop').zeros(1e6, 1e6)"},
    {"VectorsSwallowed",
     "local pl = require 'plantloop'; local t = {}; while true do pcall(function() t[#t + 1] = pl.zeros(1e5) end) end"},
    {"VectorWork", "local pl = require 'plantloop'; local v = pl.ones(1e6); while true do v = (v * 2):sin() end"},
    {"MatrixWork", "local pl = require 'plantloop'; local A = pl.ones(1200, 1200); while true do A = pl.mul(A, A) end"},
    {"RangeTooLarge", "require('plantloop').range(0, 1, 1e-9)"},
    {"JoinGrows", "local pl = require 'plantloop'; local v = pl.ones(2); while true do v = pl.join(v, v) end"},
    {"UnpackBomb", "while true do pcall(table.unpack, {}, 1, 9e5) end"},
    {"ReplaceWhileStopped", "pcall(function() while true do end end); ('x'):gsub('x', function() print 'went on' end)"},
};

INSTANTIATE_TEST_SUITE_P(All, Bombs, ::testing::ValuesIn(bombs), [](const auto& each) { return each.param.name; });

using Limits = Workshop;

TEST_F(Limits, OfInstructionsSayWhereTheScriptWas) {
  options.max_instructions = 100'000;
  const ScriptResult result = run("local x = 0\nwhile true do\n  x = x + 1\nend");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, ::testing::MatchesRegex(
                                   "experiment.lua:[23]: stopped: the script took 100000 instructions, its limit.*\n"));
  EXPECT_EQ(run("for i = 1, 1e4 do end").status, script_done);
}

TEST_F(Limits, OfMemoryCountWhatLivesAndNotWhatWas) {
  options.max_memory = std::size_t{32} << 20;
  EXPECT_EQ(run("for i = 1, 1000 do local s = ('x'):rep(1e6) end").status, script_done);
  EXPECT_EQ(run("local pl = require 'plantloop'; for i = 1, 1000 do local v = pl.zeros(1e5) end").status, script_done);
  const ScriptResult result = run("local s = ('x'):rep(4e7)");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, HasSubstr("the script needs more than 32 MB of memory, its limit"));
}

TEST_F(Limits, CountTheMemoryOfRuns) {
  write_lag();
  options.max_memory = std::size_t{16} << 20;
  // Each run holds some 2 MB: one after the other they fit, kept they do not.
  const std::string one =
      "local pl = require 'plantloop'; local d = pl.load 'lag.yaml'; local kept = {}\n"
      "for i = 1, 30 do local r = d:run{solver = 'rk4', step = 1e-4}; ";
  EXPECT_EQ(run(one + "end").status, script_done);
  const ScriptResult result = run(one + "kept[i] = r end");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, HasSubstr("memory"));
}

TEST_F(Limits, HoldForTheRecordingOfARunWhileItGrows) {
  write_lag();
  options.max_memory = std::size_t{16} << 20;
  const ScriptResult result = run("require('plantloop').load('lag.yaml'):run{solver = 'rk4', step = 1e-6}");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, HasSubstr("memory"));
}

TEST_F(Limits, IncludeARequestToStop) {
  std::atomic<bool> cancel{false};
  options.cancel = &cancel;
  std::thread other([&cancel] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    cancel = true;
  });
  const ScriptResult result = run("while true do pcall(function() while true do end end) end");
  other.join();
  EXPECT_EQ(result.status, script_failed);
  EXPECT_THAT(result.messages, HasSubstr("stopped on request"));
}

TEST_F(Limits, DoNotEndWhatIsCaughtWithinThem) {
  EXPECT_EQ(printed("print(pcall(error, 'mine')); print(select(2, pcall(function() local f; f() end)))"),
            "false\tmine\nexperiment.lua:1: attempt to call a nil value (local 'f')");
  EXPECT_EQ(
      printed(
          "local function f() return 1 + f() end; local ok, why = pcall(f); print(ok, why:match('stack overflow'))"),
      "false\tstack overflow");
}

}  // namespace
}  // namespace plantloop
