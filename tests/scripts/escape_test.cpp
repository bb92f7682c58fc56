// Scripts that try to reach what they must not: each attack either fails or finds nothing.

#include <fstream>

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Attack {
  const char* name;
  const char* script;  // prints "escaped" when it got through
};

class Escape : public Workshop, public ::testing::WithParamInterface<Attack> {};

TEST_P(Escape, IsNotPossible) {
  std::ofstream(outside() / "secret.txt") << "the secret";
  write("plain.txt", "plain");
  write(".hidden/token", "the secret");
  fs::create_symlink(outside() / "secret.txt", "link.txt");
  fs::create_directory_symlink(outside(), "up");
  fs::create_symlink(outside() / "made.txt", "dangling.txt");
  write("tool.txt", "#!/bin/sh\n");
  fs::permissions("tool.txt", fs::perms::owner_all);
  options.time_limit = 20;
  const ScriptResult result = run(GetParam().script);
  EXPECT_EQ(result.output.find("escaped"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("the secret"), std::string::npos) << result.output;
  EXPECT_EQ(read((outside() / "secret.txt").string()), "the secret");
  EXPECT_FALSE(fs::exists(outside() / "made.txt"));
  EXPECT_FALSE(fs::exists(".hidden/made.txt"));
  EXPECT_EQ(read("tool.txt"), "#!/bin/sh\n");
}

const Attack attacks[] = {
    {"Os", "if os or io or debug or package then print 'escaped' end"},
    {"Loaders", "if load or loadstring or dofile or loadfile or collectgarbage then print 'escaped' end"},
    {"OsThroughGlobals", "if _G.os or _ENV.io or rawget(_G, 'debug') then print 'escaped' end"},
    {"Dump", "if string.dump or ('').dump then print 'escaped' end"},
    {"RequireOs", "print(pcall(require, 'os') and 'escaped'); print(pcall(require, 'io') and 'escaped')"},
    {"RequireOutside",
     "for _, name in ipairs{'../secret', '/etc/passwd', 'up.secret', '..secret', 'a/b', ''} do\n"
     "  if pcall(require, name) then print 'escaped' end\nend"},
    {"PackageLoaded", "local pl = require 'plantloop'; if pl.loaded or pl.io or pl.os then print 'escaped' end"},
    {"MetatableOfTexts",
     "local m = getmetatable('')\nif type(m) == 'table' then m.__index = function() return 'escaped' end; "
     "print(('x').y) end"},
    {"MetatableOfObjects",
     "local pl = require 'plantloop'\n"
     "for _, o in ipairs{pl.zeros(1), pl.figure()} do\n"
     "  if type(getmetatable(o)) == 'table' then print 'escaped' end\n"
     "  if pcall(setmetatable, o, {}) then print 'escaped' end\nend"},
    {"Finalizer", "if pcall(setmetatable, {}, {__gc = function() end}) then print 'escaped' end"},
    {"FinalizerHiddenByIndex",
     "local m = setmetatable({}, {__index = {__gc = function() print 'escaped' end}})\n"
     "for i = 1, 1e5 do setmetatable({}, m) end"},
    {"FinalizerSetLater",
     "local m = {}\nfor i = 1, 1e5 do setmetatable({}, m); m.__gc = function() print 'escaped' end; m.__gc = nil end"},
    {"ReadAbsolute", "local pl = require 'plantloop'; print(pcall(pl.read, '/etc/passwd') and 'escaped')"},
    {"ReadAbove", "local pl = require 'plantloop'; print(pcall(pl.read, '../secret.txt') and 'escaped')"},
    {"ReadAboveThroughProject",
     "local pl = require 'plantloop'; print(pcall(pl.read, pl.project .. '/../secret.txt') and 'escaped')"},
    {"ReadLink", "local pl = require 'plantloop'; print(pcall(pl.read, 'link.txt') and 'escaped')"},
    {"ReadLinkedFolder", "local pl = require 'plantloop'; print(pcall(pl.read, 'up/secret.txt') and 'escaped')"},
    {"ReadHidden", "local pl = require 'plantloop'; print(pcall(pl.read, '.hidden/token') and 'escaped')"},
    {"ReadDevice", "local pl = require 'plantloop'; print(pcall(pl.read, '/dev/zero') and 'escaped')"},
    {"ReadWithNul",
     "local pl = require 'plantloop'; print(pcall(pl.read, 'plain.txt\\0/../../secret.txt') and 'escaped')"},
    {"ReadAddress", "local pl = require 'plantloop'; print(pcall(pl.read, 'http://example.org/') and 'escaped')"},
    {"LoadOutside",
     "local pl = require 'plantloop'\n"
     "for _, p in ipairs{'/etc/passwd', '../secret.txt', 'link.txt', 'up/secret.txt'} do\n"
     "  local ok, message = pcall(pl.load, p)\n"
     "  if ok then print 'escaped' end\n  print(message)\nend"},
    {"ImportOutside",
     "local pl = require 'plantloop'\n"
     "print(pcall(pl.diagram, 'plantloop: 1\\nimport: [../secret.txt]\\nblocks: {x: 1}\\nsimulation: {stop: 1}\\n'))"},
    {"CsvOutside", "local pl = require 'plantloop'; print(pcall(pl.read_csv, '../secret.txt') and 'escaped')"},
    {"WriteAbsolute", "local pl = require 'plantloop'; print(pcall(pl.write, '/tmp/made.txt', 'x') and 'escaped')"},
    {"WriteAbove", "local pl = require 'plantloop'; print(pcall(pl.write, '../made.txt', 'x') and 'escaped')"},
    {"WriteAboveInTheMiddle",
     "local pl = require 'plantloop'; print(pcall(pl.write, 'a/../../made.txt', 'x') and 'escaped')"},
    {"WriteThroughLink", "local pl = require 'plantloop'; print(pcall(pl.write, 'link.txt', 'x') and 'escaped')"},
    {"WriteThroughLinkedFolder",
     "local pl = require 'plantloop'; print(pcall(pl.write, 'up/made.txt', 'x') and 'escaped')"},
    {"WriteThroughDanglingLink", "local pl = require 'plantloop'; pcall(pl.write, 'dangling.txt', 'x')"},
    {"WriteHidden", "local pl = require 'plantloop'; print(pcall(pl.write, '.hidden/made.txt', 'x') and 'escaped')"},
    {"WriteAProgram", "local pl = require 'plantloop'; print(pcall(pl.write, 'tool.txt', 'x') and 'escaped')"},
    {"WriteAScript", "local pl = require 'plantloop'; print(pcall(pl.write, 'made.sh', 'x') and 'escaped')"},
    {"FigureAbove",
     "local pl = require 'plantloop'; local f = pl.figure(); f:line({0, 1}, {0, 1})\n"
     "print(pcall(f.save, f, '../made.svg') and 'escaped'); print(pcall(f.save, f, 'up/made.svg') and 'escaped')"},
    {"MethodsOnOtherObjects",
     "local pl = require 'plantloop'\nlocal f, v = pl.figure(), pl.zeros(3)\n"
     "print(pcall(f.save, v, 'a.svg') and 'escaped'); print(pcall(v.slice, f, 1) and 'escaped')\n"
     "print(pcall(v.set, 'text', 1, 1, 1) and 'escaped'); print(pcall(f.line, io, 1, 1) and 'escaped')"},
    {"ElementsOutOfRange",
     "local pl = require 'plantloop'; local v = pl.zeros(3)\n"
     "for _, i in ipairs{0, -1, 4, 1e18, -1e18, 2^53, 0/0, 1/0, -1/0, 1.5} do\n"
     "  if pcall(function() return v[i] end) then print('escaped', i) end\n"
     "  if pcall(function() v[i] = 1 end) then print('escaped', i) end\n"
     "  if pcall(v.slice, v, i, i) then print('escaped', i) end\n"
     "  if pcall(pl.select, v, {i}) then print('escaped', i) end\nend"},
    {"SizesOutOfRange",
     "local pl = require 'plantloop'\n"
     "for _, n in ipairs{-1, 0/0, 1/0, 1.5, -1e300, math.mininteger} do\n"
     "  if pcall(pl.zeros, n) or pcall(pl.eye, n) or pcall(pl.zeros, 2, n) or pcall(pl.linspace, 0, 1, n) then\n"
     "    print('escaped', n)\n  end\nend"},
    {"ShebangBytecode", "print(pcall(require, 'bytecode') and 'escaped')"},
};

INSTANTIATE_TEST_SUITE_P(All, Escape, ::testing::ValuesIn(attacks), [](const auto& each) { return each.param.name; });

using Sandbox = Workshop;

TEST_F(Sandbox, RefusesBytecode) {
  EXPECT_EQ(run(std::string_view("\x1bLuaT\0\x19\x93\r\n\x1a\n", 12)).status, script_input_wrong);
  write("bytecode.lua", std::string_view("\x1bLuaT\0\x19\x93\r\n\x1a\n", 12));
  EXPECT_THAT(complaint("require 'bytecode'"), HasSubstr("attempt to load a binary chunk"));
}

TEST_F(Sandbox, SaysWhatIsMissingAndWhatThereIsInstead) {
  EXPECT_THAT(run("os.execute('ls')").messages, HasSubstr("'os' is not available to experiments; pl.read"));
}

TEST_F(Sandbox, HasExactlyTheGlobalsOfItsList) {
  EXPECT_EQ(
      printed(
          "local names = {}; for name in pairs(_G) do names[#names + 1] = name end; print(table.concat(names, ' '))"),
      "_G _VERSION arg assert coroutine error getmetatable ipairs math next pairs pcall print rawequal rawget rawlen "
      "rawset require select setmetatable string table tonumber tostring type utf8 xpcall");
}

}  // namespace
}  // namespace plantloop
