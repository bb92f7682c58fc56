// Lua's patterns, matched by us: the manual's examples, and the bounds of the work.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using Patterns = Workshop;

TEST_F(Patterns, FindAsTheManualSays) {
  EXPECT_EQ(value("('hello Lua user'):find('Lua')"), "7\t9");
  EXPECT_EQ(value("('hello'):find('l+')"), "3\t4");
  EXPECT_EQ(value("('hello'):find('xyz')"), "nil");
  EXPECT_EQ(value("('a.b'):find('.', 1, true)"), "2\t2");
  EXPECT_EQ(value("('hello'):find('', 10)"), "nil");
  EXPECT_EQ(value("('hello'):find('', 6)"), "6\t5");
  EXPECT_EQ(value("('abc'):find('b', -2)"), "2\t2");
  EXPECT_EQ(value("('key = value'):match('(%w+)%s*=%s*(%w+)')"), "key\tvalue");
  EXPECT_EQ(value("('2026-11-23'):match('^(%d+)-(%d+)-(%d+)$')"), "2026\t11\t23");
  EXPECT_EQ(value("('f(a(b)c)d'):match('%b()')"), "(a(b)c)");
  EXPECT_EQ(value("('THE (quick) fox'):find('%((%a+)%)')"), "5\t11\tquick");
  EXPECT_EQ(value("('THE (quick) fox'):gsub('%f[%a]%a+', '<%0>')"), "<THE> (<quick>) <fox>\t3");
  EXPECT_EQ(value("('flaaap'):match('()aa()')"), "3\t5");
  EXPECT_EQ(value("([[\"it's\"]]):match([[(['\"])(.-)%1]])"), "\"\tit's");
  EXPECT_EQ(value("('  x  '):match('^%s*(.-)%s*$') .. '|'"), "x|");
  EXPECT_EQ(value("('a]b'):match('[]]'), ('a-b'):match('[a%-]+'), ('abc'):match('[^a]+'), ('x9'):match('[g-z%d]+')"),
            "]\ta-\tbc\tx9");
  EXPECT_EQ(value("('ab'):match('a?b?c?'), ('aaa'):match('a-$')"), "ab\taaa");
}

TEST_F(Patterns, ReplaceAndIterateAsTheManualSays) {
  EXPECT_EQ(value("('hello world'):gsub('(%w+)', '%1 %1')"), "hello hello world world\t2");
  EXPECT_EQ(value("('hello world'):gsub('%w+', '%0 %0', 1)"), "hello hello world\t1");
  EXPECT_EQ(value("('$name is $n'):gsub('%$(%w+)', {name = 'x'})"), "x is $n\t2");
  EXPECT_EQ(value("('abc'):gsub('%w', function(c) return c == 'b' and 'B' end)"), "aBc\t3");
  EXPECT_EQ(value("('abc'):gsub('', '-')"), "-a-b-c-\t4");
  EXPECT_EQ(value("('aaa'):gsub('^a', 'b')"), "baa\t1");
  EXPECT_EQ(value("('50%'):gsub('%%', '%%%%')"), "50%%\t1");
  EXPECT_EQ(printed("local s = ''; for k, v in ('a=1, b=2'):gmatch('(%w+)=(%w+)') do s = s .. k .. v end; print(s)"),
            "a1b2");
  EXPECT_EQ(printed("local n = 0; for w in ('one two'):gmatch('%a*') do n = n + 1 end; print(n)"), "2");
}

TEST_F(Patterns, AreRefusedWhenTheyAreNone) {
  EXPECT_THAT(complaint("('a'):find('[a')"), HasSubstr("find: the pattern has a '[' that is not closed"));
  EXPECT_THAT(complaint("('a'):find('a%')"), HasSubstr("the pattern ends with '%'"));
  EXPECT_THAT(complaint("('a'):match('(a')"), HasSubstr("a '(' that is not closed"));
  EXPECT_THAT(complaint("('a'):match('a)')"), HasSubstr("a ')' without its '('"));
  EXPECT_THAT(complaint("('a'):match('%1')"), HasSubstr("no capture %1"));
  EXPECT_THAT(complaint("('a'):gsub('a', '%2')"), HasSubstr("no capture %2"));
  EXPECT_THAT(complaint("('a'):find('%f')"), HasSubstr("'%f' in a pattern needs a set"));
  EXPECT_THAT(complaint("('a'):find('%bx')"), HasSubstr("'%b' in a pattern needs two characters"));
}

}  // namespace
}  // namespace plantloop
