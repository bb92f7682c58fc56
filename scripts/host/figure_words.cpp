// Lua tables to words of figures.

#include "scripts/host/figure_words.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/base/colors.h"
#include "scripts/host/objects.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

using Kind = FigureWord::Kind;

// "a, b or c"
std::string one_of(const std::vector<std::string_view>& choices) {
  std::string text(choices.front());
  for (std::size_t i = 1; i < choices.size(); ++i)
    text += fmt::format("{}{}", i + 1 < choices.size() ? ", " : " or ", choices[i]);
  return text;
}

double checked_number(const Options& options, const FigureWord& word, const std::string& key) {
  const double value = *options.number(key.c_str());
  const bool fits = value >= word.least && value <= word.most && (!word.whole || value == static_cast<long>(value));
  if (fits) return value;
  const std::string kind = word.whole ? "a whole number" : "a number";
  if (word.most < 1e300)
    throw ScriptError(fmt::format("'{}' must be {} from {:g} to {:g}", key, kind, word.least, word.most));
  throw ScriptError(fmt::format("'{}' must be {} of at least {:g}", key, kind, word.least));
}

// Numbers on top of the stack; a not-a-number is an end that is left open.
void read_numbers(lua_State* L, const FigureWord& word, std::size_t count, const char* wanted, FigureEntry& made) {
  const Array& values = vector_argument(L, -1, std::string(word.name));
  if (values.size() != static_cast<std::int64_t>(count)) throw ScriptError(fmt::format("'{}' {}", word.name, wanted));
  for (std::int64_t i = 0; i < values.size(); ++i) {
    const double value = values.data()[i];
    made.numbers.push_back(value == value ? number_expression(value) : nullptr);
  }
}

void read_limits(lua_State* L, const FigureWord& word, FigureEntry& made) {
  read_numbers(L, word, 2, "are two numbers, {lower, upper}", made);
  const ExpressionPtr &lower = made.numbers[0], &upper = made.numbers[1];
  if (lower && upper && !(lower->number < upper->number))
    throw ScriptError(fmt::format("'{}' are {{lower, upper}} in rising order, here is {{{:g}, {:g}}}", word.name,
                                  lower->number, upper->number));
}

void check_logarithmic(const FigureBlock& block, std::string_view scale, std::string_view limits) {
  const FigureEntry* ends = block.find(limits);
  if (block.text(scale) != "log" || !ends) return;
  for (const ExpressionPtr& end : ends->numbers)
    if (end && !(end->number > 0))
      throw ScriptError(
          fmt::format("a logarithmic axis has only values greater than 0, and '{}' has {:g}", limits, end->number));
}

void read_list(lua_State* L, const Options& options, const FigureWord& word, FigureEntry& made) {
  if (!lua_istable(L, -1)) options.wrong(std::string(word.name).c_str(), "a list of tables");
  for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i) {
    made.parts.push_back(block_at(L, lua_gettop(L), std::string(word.parts->what), *word.parts));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

void read_axis(lua_State* L, const Options& options, const FigureWord& word, FigureEntry& made) {
  const std::string key(word.name);
  if (lua_type(L, -1) == LUA_TSTRING) {
    made.text = lua_tostring(L, -1);
    return;
  }
  if (!lua_istable(L, -1)) options.wrong(key.c_str(), "a label or {label = ..., limits = {...}}");
  made.parts.push_back(block_at(L, lua_gettop(L), fmt::format("the axis '{}'", key), *word.parts));
}

FigureEntry entry_of(lua_State* L, const Options& options, const FigureWord& word) {
  const std::string key(word.name);
  FigureEntry made;
  made.word = &word;
  switch (word.kind) {
    case Kind::text:
      made.text = options.text(key.c_str());
      return made;
    case Kind::number:
      made.numbers = {number_expression(checked_number(options, word, key))};
      return made;
    case Kind::flag:
      made.flag = options.flag(key.c_str());
      return made;
    case Kind::choice:
      made.text = options.text(key.c_str());
      if (std::find(word.choices.begin(), word.choices.end(), made.text) == word.choices.end())
        options.wrong(key.c_str(), one_of(word.choices).c_str());
      return made;
    case Kind::color:
      made.text = options.text(key.c_str());
      if (!color_number(made.text))
        throw ScriptError(fmt::format("there is no colour '{}': it is a name, as blue, or #RRGGBB", made.text));
      return made;
    default:
      break;
  }
  options.push(key.c_str());
  if (word.kind == Kind::limits)
    read_limits(L, word, made);
  else if (word.kind == Kind::numbers)
    read_numbers(L, word, word.count, "is four parts of the panel, {left, bottom, width, height}", made);
  else if (word.kind == Kind::axis)
    read_axis(L, options, word, made);
  else
    read_list(L, options, word, made);
  lua_pop(L, 1);
  return made;
}

std::string type_of(const FigureWord& word) {
  switch (word.kind) {
    case Kind::number:
      return word.whole ? "integer" : "number";
    case Kind::numbers:
    case Kind::limits:
      return "number[]";
    case Kind::flag:
      return "boolean";
    case Kind::axis:
      return "string|table";
    case Kind::list:
      return "table[]";
    default:
      return "string";
  }
}

std::vector<FigureWord> axes(std::initializer_list<std::string_view> names) {
  std::vector<FigureWord> words;
  for (const std::string_view name : names)
    words.push_back({.name = name, .kind = Kind::axis, .doc = "an axis, or its label", .parts = &axis_words()});
  return words;
}

FigureWords with_axes(const FigureWords& words, std::initializer_list<std::string_view> names) {
  FigureWords made{words.what, axes(names)};
  made.words.insert(made.words.end(), words.words.begin(), words.words.end());
  return made;
}

}  // namespace

FigureBlock block_of(lua_State* L, const Options& options, const FigureWords& words) {
  FigureBlock block{&words, {}, {}};
  for (const FigureWord& word : words.words)
    if (options.has(std::string(word.name).c_str())) block.entries.push_back(entry_of(L, options, word));
  for (const auto& [scale, limits] :
       {std::pair{"scale", "limits"}, {"right_scale", "right_limits"}, {"x_scale", "x_limits"}})
    check_logarithmic(block, scale, limits);
  return block;
}

FigureBlock block_at(lua_State* L, int index, const std::string& what, const FigureWords& words) {
  return block_of(L, Options(L, index, what, words.names()), words);
}

std::string table_type(const FigureWords& words) {
  std::string members;
  for (const FigureWord& word : words.words)
    members += fmt::format("{}{}?: {}", members.empty() ? "" : ", ", word.name, type_of(word));
  return "{" + members + "}";
}

const FigureWords& script_panel_words() {
  static const FigureWords words = with_axes(frame_words(), {"x", "y", "right"});
  return words;
}

const FigureWords& script_inset_words() {
  static const FigureWords words = with_axes(inset_frame_words(), {"x", "y"});
  return words;
}

const FigureWords& script_figure_words() {
  // A figure's title, height and x are its own; all else is its first panel's.
  static const FigureWords words = [] {
    FigureWords made = picture_words();
    for (const FigureWord& word : script_panel_words().words)
      if (!made.find(word.name)) made.words.push_back(word);
    return made;
  }();
  return words;
}

}  // namespace plantloop::lua
