// What a script finds of Lua, how its errors read, and its files.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Language = Workshop;

TEST_F(Language, GivesArgumentsAndPrints) {
  const ScriptResult result = run("print(arg[0], #arg, arg[1], arg[2], ...)", {"a", "b c"});
  EXPECT_EQ(result.status, script_done);
  EXPECT_EQ(result.output, "experiment.lua\t2\ta\tb c\ta\tb c\n");
}

TEST_F(Language, HasTheUsualLibraries) {
  EXPECT_EQ(value("('%5.2f|%s'):format(1.5, 'x'), #'abc', ('x'):rep(3, '-'), ('abc'):upper()"),
            " 1.50|x\t3\tx-x-x\tABC");
  EXPECT_EQ(value("table.concat({1, 2, 'x'}, ', '), select('#', table.unpack({1, nil, 3}, 1, 3)), #table.pack(1, 2)"),
            "1, 2, x\t3\t2");
  EXPECT_EQ(printed("local t = {3, 1, 2}; table.sort(t); table.insert(t, 1, 0); table.insert(t, 9); "
                    "print(table.concat(t, ' '), table.remove(t, 1), table.remove(t), #t)"),
            "0 1 2 3 9\t0\t9\t3");
  EXPECT_EQ(
      printed("local t = {'b', 'a', 'c'}; table.sort(t, function(x, y) return x > y end); print(table.unpack(t))"),
      "c\tb\ta");
  EXPECT_EQ(value("table.unpack(table.move({1, 2, 3}, 2, 3, 1))"), "2\t3\t3");
  EXPECT_EQ(value("math.floor(2.5), math.type(1), utf8.len('αβ'), tostring(nil), type(pl.zeros(1))"),
            "2\tinteger\t2\tnil\tuserdata");
  EXPECT_EQ(printed("local co = coroutine.wrap(function(a) local b = coroutine.yield(a + 1); return b * 2 end); "
                    "print(co(1), co(10))"),
            "2\t20");
}

TEST_F(Language, HasCoroutinesAndHandlersAsInLua) {
  EXPECT_EQ(printed("local co = coroutine.wrap(function() error('mine', 0) end); print(pcall(co)); print(pcall(co))"),
            "false\tmine\nfalse\tcannot resume dead coroutine");
  EXPECT_EQ(
      printed(
          "local log = ''; local co = coroutine.create(function()\n"
          "  local x <close> = setmetatable({}, {__close = function() log = 'closed' end}); coroutine.yield(1) end)\n"
          "print(coroutine.resume(co)); print(coroutine.close(co), log, coroutine.status(co))\n"
          "print(pcall(coroutine.close, coroutine.running()))"),
      "true\t1\ntrue\tclosed\tdead\nfalse\ta running coroutine cannot be closed");
  EXPECT_EQ(
      printed(
          "print(xpcall(function(a, b) return a + b end, print, 1, 2))\n"
          "print(xpcall(function() error('x', 0) end, function(e) return 'caught ' .. e end))\n"
          "local co = coroutine.wrap(function() return xpcall(function() return coroutine.yield(1) end, print) end)\n"
          "print(co()); print(co(5))"),
      "true\t3\nfalse\tcaught x\n1\ntrue\t5");
}

TEST_F(Language, GoesThroughKeysInTheSameOrderEveryTime) {
  EXPECT_EQ(printed("local s = ''; for k, v in pairs{b = 1, a = 2, [2] = 3, [1] = 4, [true] = 5} do s = s .. "
                    "tostring(k) .. v .. ' ' end; print(s)"),
            "14 23 a2 b1 true5 ");
  EXPECT_EQ(printed("local t = {a = 1, b = 2}; for k in pairs(t) do t[k] = nil end; print(next(t))"), "nil");
  EXPECT_EQ(printed("print(math.random())"), printed("print(math.random())"));
}

TEST_F(Language, SaysWhereAnErrorIsAndHowItCameThere) {
  const ScriptResult result =
      run("local function inner(x)\n  return x.y.z\nend\nlocal function outer()\n  local v = inner({})\n  return "
          "v\nend\nouter()");
  EXPECT_EQ(result.status, script_failed);
  EXPECT_EQ(result.messages,
            "experiment.lua:2: attempt to index a nil value (field 'y')\n"
            "  called from experiment.lua:5 in 'outer'\n"
            "  called from experiment.lua:8\n");
}

TEST_F(Language, CallsAScriptThatIsNoLuaWrongInput) {
  const ScriptResult result = run("local x = = 3");
  EXPECT_EQ(result.status, script_input_wrong);
  EXPECT_EQ(result.messages, "experiment.lua:1: unexpected symbol near '='\n");
  EXPECT_EQ(run_script("nowhere.lua", {}, options), script_input_wrong);
}

TEST_F(Language, ReportsErrorsThatAreNoTexts) {
  EXPECT_THAT(run("error({})").messages, HasSubstr("the error is a table, which has no text"));
  EXPECT_THAT(run("error()").messages, HasSubstr("which has no text"));
  EXPECT_THAT(run("error(setmetatable({}, {__tostring = function() return 'mine' end}))").messages, HasSubstr("mine"));
  EXPECT_THAT(run("error(setmetatable({}, {__tostring = function() error('again') end}))").messages,
              Not(HasSubstr("terminate")));
}

TEST_F(Language, NamesLongPathsInFull) {
  const std::string folder(70, 'f');
  write(folder + "/long.lua", "x.y = 1\n");
  std::ostringstream messages;
  options.messages = &messages;
  EXPECT_EQ(run_script(folder + "/long.lua", {}, options), script_failed);
  EXPECT_THAT(messages.str(), ::testing::StartsWith(folder + "/long.lua:1: "));
}

TEST_F(Language, RequiresModulesOfTheProject) {
  write("tools.lua", "local M = {}\nfunction M.twice(x) return 2*x end\nreturn M\n");
  write("scripts/lib/deep/more.lua", "return {name = ...}\n");
  EXPECT_EQ(value("require('tools').twice(4), require('deep.more').name, require('tools') == require('tools')"),
            "8\tdeep.more\ttrue");
  EXPECT_THAT(complaint("require 'absent'"), HasSubstr("there is no module 'absent': no file absent.lua"));
  write("self.lua", "return require 'self'");
  EXPECT_THAT(complaint("require 'self'"), HasSubstr("module 'self' needs itself"));
  write("broken.lua", "return = 1");
  EXPECT_THAT(complaint("require 'broken'"), HasSubstr("broken.lua:1:"));
}

TEST_F(Language, ReadsAndWritesFiles) {
  EXPECT_EQ(printed("print(pl.write('notes/a.txt', 'hello')); print(pl.read 'notes/a.txt')"), "notes/a.txt\nhello");
  write("data.csv", "time,y\n0,1\n1,3\n");
  EXPECT_EQ(printed("local d = pl.read_csv 'data.csv'; print(d.y, d.time)"), "[1, 3]\t[0, 1]");
  EXPECT_EQ(value("pl.read(pl.project .. '/data.csv'):sub(1, 4)"), "time");
}

TEST_F(Language, HasDeclarationsForEditors) {
  const std::string stubs = lua_stubs();
  EXPECT_THAT(stubs, HasSubstr("---@meta plantloop\n"));
  EXPECT_THAT(stubs, HasSubstr("---@param from number\n---@param to number\n---@param count? integer\n---@return "
                               "pl.Vector\nfunction pl.linspace(from, to, count) end\n"));
  EXPECT_THAT(stubs, HasSubstr("function Run:measure(measure, column, options) end"));
  EXPECT_THAT(stubs, HasSubstr("function Vector:sum() end"));
  write("stubs.lua", stubs);
  EXPECT_EQ(run_script("stubs.lua", {}, options), script_done);  // they are Lua
}

}  // namespace
}  // namespace plantloop
