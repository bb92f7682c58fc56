// Appends operations to a Record.

#include <cassert>
#include <utility>

#include "engine/program/record.h"

namespace plantloop {

namespace {

thread_local Recorder* current_recorder = nullptr;
constexpr std::uint32_t none = 0xffffffff;

}  // namespace

Recorder::Recorder() : charge_(*this), previous_(current_recorder) { current_recorder = this; }
Recorder::~Recorder() { current_recorder = previous_; }
Recorder* Recorder::current() { return current_recorder; }

std::uint32_t Recorder::add_site(std::string path, std::string method, const Mark& mark) {
  record.sites.push_back({std::move(path), std::move(method), mark});
  return static_cast<std::uint32_t>(record.sites.size() - 1);
}

RateIndex Recorder::add_rate(const Rational& period, const Rational& offset) {
  for (std::size_t i = 1; i < record.rates.size(); ++i) {
    const RecordedRate& known = record.rates[i];
    if (!known.triggered && known.period == period && known.offset == offset) return static_cast<RateIndex>(i);
  }
  record.rates.push_back({period, offset});
  return static_cast<RateIndex>(record.rates.size() - 1);
}

RateIndex Recorder::add_trigger() {
  record.rates.push_back({.period = {}, .offset = {}, .triggered = true});
  return static_cast<RateIndex>(record.rates.size() - 1);
}

Value Recorder::leaf(Op op, std::uint32_t index) {
  RecordedNode node;
  node.op = op;
  node.rate = op == Op::discrete || op == Op::hit ? rate : RateIndex{0};  // other leaves do not wait for a block's hits
  node.a = index;
  node.site = site;
  record.nodes.push_back(node);
  return Value::node(static_cast<std::uint32_t>(record.nodes.size() - 1));
}

Value Recorder::parameter(std::string name, double value, std::string unit) {
  record.parameters.push_back({std::move(name), value, std::move(unit)});
  return leaf(Op::parameter, static_cast<std::uint32_t>(record.parameters.size() - 1));
}

Value Recorder::time() { return leaf(Op::time, 0); }
Value Recorder::state(std::uint32_t index) { return leaf(Op::state, index); }

// What changes at the hits of one rate, as it is read at those of another.
Value Recorder::copy(Op op, std::uint32_t index, RateIndex changes, RateIndex reads) {
  const RateIndex before = std::exchange(rate, changes);
  RecordedNode node;
  node.op = Op::copy;
  node.rate = reads;
  node.a = leaf(op, index).id();
  node.site = site;
  record.nodes.push_back(node);
  rate = before;
  return Value::node(static_cast<std::uint32_t>(record.nodes.size() - 1));
}

Value Recorder::discrete(std::uint32_t index) {
  if (latches_.size() <= index) latches_.resize(index + 1, none);
  if (latches_[index] == none) {
    // The copy is what everybody reads: it changes at the hits of the state's rate, after the update it still shows
    // x[k].
    const RateIndex own = record.discretes[index].rate;
    latches_[index] = copy(Op::discrete, index, own, own).id();
  }
  return Value::node(latches_[index]);
}

Value Recorder::discrete_before(std::uint32_t index) {
  return copy(Op::discrete, index, record.discretes[index].rate, rate);
}

Value Recorder::implicit(std::uint32_t index) {
  const Value unknown = leaf(Op::implicit, index);
  record.nodes[unknown.id()].rate = rate;  // of a sampled block: found at its hits
  return unknown;
}

Value Recorder::hit(RateIndex of) { return copy(Op::hit, of, of, of); }

Value Recorder::segment(std::vector<Value> times) {
  RecordedSchedule schedule;
  schedule.times = std::move(times);
  schedule.site = site;
  record.schedules.push_back(std::move(schedule));
  return leaf(Op::segment, static_cast<std::uint32_t>(record.schedules.size() - 1));
}

Value Recorder::beats(Value first, Value period) {
  RecordedSchedule schedule;
  schedule.periodic = true;
  schedule.first = first;
  schedule.period = period;
  schedule.site = site;
  record.schedules.push_back(std::move(schedule));
  return leaf(Op::segment, static_cast<std::uint32_t>(record.schedules.size() - 1));
}

Value Recorder::wire() {
  record.wires.emplace_back();
  record.wire_bound.push_back(0);
  return leaf(Op::wire, static_cast<std::uint32_t>(record.wires.size() - 1));
}

void Recorder::bind(Value wire, Value driver) {
  const RecordedNode& node = record.nodes[wire.id()];
  assert(node.op == Op::wire);
  record.wires[node.a] = driver;
  record.wire_bound[node.a] = 1;
}

std::vector<Value> Recorder::kernel(KernelUse use) {
  use.site = site;
  use.continuous = rate == 0;
  const int outputs = use.kernel->outputs();
  record.kernels.push_back(std::move(use));
  RecordedNode node;
  node.op = Op::kernel;
  node.rate = rate;
  node.activation = activation;
  node.a = static_cast<std::uint32_t>(record.kernels.size() - 1);
  node.site = site;
  record.nodes.push_back(node);
  const auto id = static_cast<std::uint32_t>(record.nodes.size() - 1);
  std::vector<Value> values;
  for (int i = 0; i < outputs; ++i) {
    RecordedNode output = node;
    output.op = Op::kernel_output;
    output.a = id;
    output.b = static_cast<std::uint32_t>(i);
    record.nodes.push_back(output);
    values.push_back(Value::node(static_cast<std::uint32_t>(record.nodes.size() - 1)));
  }
  return values;
}

std::uint32_t Recorder::id_of(Value value) {
  if (!value.is_known()) return value.id();
  record.constants.push_back(value.number());
  const RateIndex before = std::exchange(rate, RateIndex{0});
  const Value node = leaf(Op::constant, static_cast<std::uint32_t>(record.constants.size() - 1));
  rate = before;
  return node.id();
}

Value Recorder::operation(Op op, Value a, Value b, Value c) {
  const int arity = arity_of(op);
  RecordedNode node;
  node.op = op;
  node.plain = plain;
  node.rate = rate;
  node.activation = activation;
  node.site = site;
  node.a = id_of(a);
  if (arity > 1) node.b = id_of(b);
  if (arity > 2) node.c = id_of(c);
  record.nodes.push_back(node);
  return Value::node(static_cast<std::uint32_t>(record.nodes.size() - 1));
}

}  // namespace plantloop
