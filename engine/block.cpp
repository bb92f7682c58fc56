// Declarations register with their block; `now`, `out` and their kind talk to the instance that is being recorded.

#include "engine/block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "engine/block_instance.h"
#include "engine/program/record.h"

namespace plantloop {

namespace {

thread_local BlockInstance* current_instance = nullptr;

template <typename Thing>
Declared declare(std::vector<const Thing*>& list, const Thing* thing, std::string_view name) {
  list.push_back(thing);
  return {name, static_cast<int>(list.size()) - 1};
}

}  // namespace

BlockInstance::BlockInstance() : previous_(current_instance) { current_instance = this; }
BlockInstance::~BlockInstance() { current_instance = previous_; }
BlockInstance& BlockInstance::current() {
  assert(current_instance != nullptr);
  return *current_instance;
}

Input::Input(Block* block, std::string_view called, InputSpec declared)
    : Declared(declare(block->inputs, this, called)), spec(declared) {
  if (!std::isnan(spec.init)) block->settable.push_back(called);
}

Inputs::Inputs(Block* block, std::string_view called, InputSpec declared)
    : Declared(declare(block->lists, this, called)), spec(declared) {}

Output::Output(Block* block, std::string_view called, OutputSpec declared)
    : Declared(declare(block->outputs_declared, this, called)), spec(declared) {}

Number::Number(Block* block, std::string_view called, NumberSpec declared)
    : Declared(declare(block->numbers, this, called)), spec(declared) {
  block->settable.push_back(called);
}

Table::Table(Block* block, std::string_view called, TableSpec declared)
    : Declared(declare(block->tables, this, called)), spec(declared) {
  block->settable.push_back(called);
}

Count::Count(Block* block, std::string_view called, CountSpec declared)
    : Declared(declare(block->counts, this, called)), spec(declared) {
  block->settable.push_back(called);
}
int Count::value() const { return BlockInstance::current().count(index); }

Choice::Choice(Block* block, std::string_view called, ChoiceSpec spec)
    : Declared(declare(block->choices, this, called)), words(spec.of.begin(), spec.of.end()), doc(spec.doc) {
  assert(!words.empty());
  block->settable.push_back(called);
}
std::string_view Choice::value() const { return BlockInstance::current().choice(index); }

Text::Text(Block* block, std::string_view called, TextSpec declared)
    : Declared(declare(block->texts, this, called)), spec(declared) {
  block->settable.push_back(called);
}
std::string Text::value() const { return BlockInstance::current().text(index); }

State::State(Block* block, std::string_view called, StateSpec declared)
    : Declared(declare(block->states, this, called)), spec(declared) {}

Discrete::Discrete(Block* block, std::string_view called, StateSpec declared)
    : Declared(declare(block->discretes, this, called)), spec(declared) {}

Array Now::operator[](const Input& port) const { return BlockInstance::current().input(port.index); }
std::vector<Array> Now::operator[](const Inputs& port) const { return BlockInstance::current().list(port.index); }
Array Now::operator[](const Number& parameter) const { return BlockInstance::current().number(parameter.index); }
Array Now::operator[](const Table& parameter) const { return BlockInstance::current().table(parameter.index); }
Array Now::operator[](const State& state) const { return BlockInstance::current().state(state.index); }
Array Now::operator[](const Discrete& state) const { return BlockInstance::current().discrete(state.index); }
Value Now::time() const { return Recorder::current()->time(); }
Value Now::hit() const { return BlockInstance::current().hit(); }
Value Now::period() const { return BlockInstance::current().period(); }
bool Now::connected(const Input& port) const { return BlockInstance::current().connected(port.index); }
Meeting Now::meeting(const Input& port) const { return BlockInstance::current().meeting(port.index); }
Array Now::earlier(const Input& port, const Array& initial, bool steady) const {
  return BlockInstance::current().earlier(port.index, initial, steady);
}
std::string Now::path() const { return std::string(BlockInstance::current().path()); }
std::uint64_t Now::stream() const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : BlockInstance::current().path()) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}
std::vector<Activity> Now::activity(const Inputs& port) const { return BlockInstance::current().activity(port.index); }
bool Now::given(const Number& parameter) const { return BlockInstance::current().given_number(parameter.index); }
bool Now::given(const Table& parameter) const { return BlockInstance::current().given_table(parameter.index); }

std::vector<Value> Now::kernel(std::shared_ptr<const Kernel> kernel, std::vector<Value> inputs,
                               std::vector<Value> advanced) const {
  return BlockInstance::current().kernel(std::move(kernel), std::move(inputs), std::move(advanced));
}

void Target::operator=(const Array& value) const { BlockInstance::current().write(what_, index_, value); }

Jumps::Event Jumps::when(const Crossing& crossing) const { return Event(BlockInstance::current().event(crossing)); }

const Jumps::Event& Jumps::Event::set(const State& state, const Array& value) const {
  BlockInstance::current().jump(index_, false, state.index, value);
  return *this;
}
const Jumps::Event& Jumps::Event::set(const Discrete& state, const Array& value) const {
  BlockInstance::current().jump(index_, true, state.index, value);
  return *this;
}

Value segment(const Array& times) {
  return Recorder::current()->segment({times.values().begin(), times.values().end()});
}
Array implicit(const Shape& shape, const Implicit& about, const std::function<Array(const Array&)>& residual) {
  Recorder& recorder = *Recorder::current();
  const auto first = static_cast<std::uint32_t>(recorder.record.unknowns.size());
  const std::string path(BlockInstance::current().path());
  Array unknowns(shape);
  const auto suffix = [&](int i) {
    if (shape.is_scalar()) return std::string();
    return shape.rank == 1 ? fmt::format(".{}", i + 1)
                           : fmt::format(".{}.{}", i / shape.columns + 1, i % shape.columns + 1);
  };
  for (int i = 0; i < shape.size(); ++i) {
    RecordedUnknown unknown;
    unknown.name = path + suffix(i);
    unknown.site = recorder.site;
    unknown.lower = about.lower.at(i);
    unknown.upper = about.upper.at(i);
    unknown.guess = about.guess.at(i);
    recorder.record.unknowns.push_back(std::move(unknown));
    unknowns[i] = recorder.implicit(first + static_cast<std::uint32_t>(i));
  }
  const Array zero = residual(unknowns);
  for (int i = 0; i < shape.size(); ++i)
    recorder.record.unknowns[first + static_cast<std::uint32_t>(i)].residual = zero.at(i);
  return unknowns;
}

NoEvents::NoEvents() : before_(std::exchange(Recorder::current()->plain, true)) {}
NoEvents::~NoEvents() { Recorder::current()->plain = before_; }

Value beats(Value first, Value period) { return Recorder::current()->beats(first, period); }

RateKind Block::rate_kind() const {
  if (!states.empty()) return RateKind::continuous;
  if (!discretes.empty()) return RateKind::discrete;
  return inputs.empty() && lists.empty() ? RateKind::source : RateKind::any;
}

const BlockType* find_block(std::string_view name) {
  const std::vector<BlockType>& types = catalogue();
  const auto it = std::lower_bound(types.begin(), types.end(), name,
                                   [](const BlockType& t, std::string_view n) { return t.name < n; });
  return it != types.end() && it->name == name ? &*it : nullptr;
}

}  // namespace plantloop
