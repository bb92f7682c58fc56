// Graph -> Record: every block's methods run once, on symbolic values.

#include "engine/graph/record.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/graph/evaluate.h"
#include "engine/graph/static_instance.h"

namespace plantloop {
namespace {

// ".3", ".1.2", or nothing for a scalar.
std::string element_suffix(const Shape& shape, int i) {
  if (shape.is_scalar()) return {};
  if (shape.rank == 1) return fmt::format(".{}", i + 1);
  return fmt::format(".{}.{}", i / shape.columns + 1, i % shape.columns + 1);
}

class GraphRecording;

// The names of a bound expression as values that are being recorded.
class RecordedNames final : public Names {
 public:
  RecordedNames(GraphRecording& recording, const BoundExpression& bound) : recording_(recording), bound_(bound) {}
  Shape shape(std::uint32_t name) override;
  Array value(std::uint32_t name) override;
  const Array* known(std::uint32_t name) override;

 private:
  GraphRecording& recording_;
  const BoundExpression& bound_;
  Array held_;
};

// The block whose methods are running.
class RecordingInstance final : public StaticInstance {
 public:
  RecordingInstance(GraphRecording& recording, const Graph& graph) : StaticInstance(graph), recording_(recording) {}
  void begin(const GraphBlock& block);
  void finish();  // outputs that the block never wrote, jumps by element

  Array input(int index) override;
  std::vector<Array> list(int index) override;
  Array number(int index) override;
  Array table(int index) override;
  Array state(int index) override { return states_[static_cast<std::size_t>(index)]; }
  Array discrete(int index) override { return discretes_[static_cast<std::size_t>(index)]; }
  std::vector<Activity> activity(int list) override;
  Value hit() override;
  Value period() override;
  Meeting meeting(int index) override;
  Array earlier(int index, const Array& initial, bool steady) override;
  std::vector<Value> kernel(std::shared_ptr<const Kernel> kernel, std::vector<Value> inputs,
                            std::vector<Value> advanced) override;
  void write(Written what, int index, const Array& value) override;
  int event(const Crossing& crossing) override;
  void jump(int event, bool discrete, int index, const Array& value) override;

  std::uint32_t first_state() const { return first_state_; }
  std::uint32_t first_discrete() const { return first_discrete_; }

 private:
  struct Assignment {
    bool discrete;
    int index;
    Array value;
  };
  struct Event {
    Array function;
    Direction direction;
    bool of_slope, of_kernel;
    std::vector<Assignment> assignments;
    std::uint32_t site;
    bool level;
    std::string name;
  };
  Array sized(const Size& size, Array value) const;
  const Shape& state_shape(bool discrete, int index) const;
  std::uint32_t state_index(bool discrete, int index) const;

  GraphRecording& recording_;
  std::vector<Array> states_, discretes_;
  std::vector<std::uint32_t> state_at_, discrete_at_;  // first element of each
  std::vector<Event> events_;
  std::uint32_t first_state_ = 0, first_discrete_ = 0;
};

class GraphRecording {
 public:
  GraphRecording(const Graph& graph, const std::vector<Probe>& probes, std::vector<RecordedProbe>* probed)
      : g_(graph), instance_(*this, graph), probes_(probes), probed_(probed) {
    net_values_.resize(g_.nets.size());
    net_state_.resize(g_.nets.size(), new_net);
    parameter_values_.resize(g_.parameters.size());
    parameter_done_.resize(g_.parameters.size(), 0);
    recorder_.record.nodes.reserve(g_.nets.size() * 2 + g_.parameters.size());
    recorder_.record.sites.reserve(g_.blocks.size() * 3 + g_.scopes.size());
  }

  RecordedGraph run() {
    add_rates();
    block_states_.resize(g_.blocks.size());
    record_conditions();
    for (const std::uint32_t s : g_.scope_order) record_scope(s);
    record_buses_and_copies();
    for (const std::uint32_t b : g_.order) record_block(b);
    for (const std::uint32_t b : g_.order) record_reset(b);
    for (const std::uint32_t s : g_.scope_order) record_scope_reset(s);
    record_activation_jumps();
    enter(0);
    recorder_.rate = 0;
    recorder_.plain = false;
    list_signals();
    show_columns();
    record_numbers();
    result_.record = std::move(recorder_.record);
    return std::move(result_);
  }

  // The values of a net for somebody who reads it: forward references when its driver has not been recorded yet.
  const Array& value_of_net(std::uint32_t index) {
    if (net_state_[index] == new_net) {
      Array& value = net_values_[index];
      value = Array(g_.nets[index].shape);
      for (int i = 0; i < value.size(); ++i) value[i] = recorder_.wire();
      net_state_[index] = wired;
    }
    return net_values_[index];
  }

  // The same for a reader that need not be active when the net's block is: what that block showed last.
  const Array& value_seen(std::uint32_t index) {
    if (g_.activations.size() == 1) return value_of_net(index);
    const std::uint32_t own = activation_of(g_, g_.nets[index]);
    if (is_within(g_, reader_, own)) return value_of_net(index);
    const auto known = seen_.find(index);
    return known != seen_.end() ? known->second : seen_.emplace(index, held_outside(index, own)).first->second;
  }

  // The time since the last trigger, at its hits.
  Value elapsed(std::uint32_t activation) {
    const auto known = elapsed_.find(activation);
    if (known != elapsed_.end()) return known->second;
    const Stamp stamp(*this, 0, rate_of({GraphRate::Kind::discrete, g_.activations[activation].rate}));
    RecordedDiscrete last;
    last.name = g_.activations[activation].path + ".triggered";
    last.site = recorder_.site;
    last.rate = recorder_.rate;
    last.initial = last.next = recorder_.time();
    last.unit = "s";
    recorder_.record.discretes.push_back(std::move(last));
    const Value before = recorder_.discrete(static_cast<std::uint32_t>(recorder_.record.discretes.size() - 1));
    return elapsed_.emplace(activation, recorder_.operation(Op::sub, recorder_.time(), before, 0)).first->second;
  }

  // Whether what belongs to an activation runs now, and since when.
  Activity activity_of(std::uint32_t a) {
    constexpr double never = std::numeric_limits<double>::lowest();
    if (a == 0) return {{}, Truth(Value(1.0)), Value(never)};
    const GraphActivation& activation = g_.activations[a];
    std::uint32_t trigger = a;
    while (trigger != 0 && g_.activations[trigger].rate == 0) trigger = g_.activations[trigger].parent;
    const Stamp stamp(*this, 0, 0);
    recorder_.plain = true;
    recorder_.site = recorder_.add_site(activation.path, "activity", activation.declaration->mark);
    if (trigger != 0) {
      recorder_.rate = rate_of({GraphRate::Kind::discrete, g_.activations[trigger].rate});
      const Value latest = recorder_.operation(Op::copy, recorder_.time(), 0, 0);
      const Truth ever = recorder_.hit(recorder_.rate) >= Value(0.0);
      recorder_.rate = 0;
      const Value since = where(ever, latest, Value(never));
      return {activation.path, equal(since, recorder_.time()), since};
    }
    const auto known = since_.find(a);
    if (known != since_.end()) return {activation.path, Truth(gates_[a]), known->second};
    RecordedDiscrete since;
    since.name = activation.path + ".since";
    since.site = recorder_.site;
    since.initial = where(Truth(gates_[a]), recorder_.time(), Value(never));
    since.unit = "s";
    recorder_.record.discretes.push_back(std::move(since));
    const auto index = static_cast<std::uint32_t>(recorder_.record.discretes.size() - 1);
    const Value value = recorder_.discrete(index);
    recorder_.record.discretes[index].next = value;
    enabled_since_.emplace_back(a, index);
    since_.emplace(a, value);
    return {activation.path, Truth(gates_[a]), value};
  }

  // Everything recorded from now on runs under an activation.
  void enter(std::uint32_t activation) {
    reader_ = activation;
    recorder_.activation = activation == 0 ? std::uint16_t{0} : gate_numbers_[activation];
  }

  void bind_net(std::uint32_t index, Array value) {
    const GraphNet& net = g_.nets[index];
    value = value.spread(net.shape);
    if (const RateIndex rate = rate_of(net.rate); rate != 0 && net.kind != GraphNet::Kind::block_input)
      hold(value, rate);
    for (const Probe& probe : probes_) {
      if (probe.net == index) add_probe(probe, value);
    }
    if (net_state_[index] == wired) {
      for (int i = 0; i < value.size(); ++i) recorder_.bind(net_values_[index][i], value[i]);
    }
    net_values_[index] = std::move(value);
    net_state_[index] = done;
  }

  const Array& value_of_parameter(std::uint32_t index) {
    if (!parameter_done_[index]) record_parameter(index);
    return parameter_values_[index];
  }

  const Graph& graph() const { return g_; }
  Recorder& recorder() { return recorder_; }
  RateIndex rate_of(GraphRate rate) const {
    return rate.kind == GraphRate::Kind::discrete ? rates_[rate.index] : RateIndex{0};
  }
  void use(ParameterUse use) { result_.uses.push_back(use); }
  std::uint32_t block_site(const GraphBlock& block, const char* method) {
    return recorder_.add_site(block.path, method, block.declaration->mark);
  }

 private:
  enum NetState : std::uint8_t { new_net, wired, done };

  // What is recorded while one of these lives bears other marks than what is around it.
  class Stamp {
   public:
    Stamp(GraphRecording& recording, std::uint32_t reader, RateIndex rate)
        : recording_(recording),
          reader_(recording.reader_),
          activation_(recording.recorder_.activation),
          rate_(recording.recorder_.rate),
          site_(recording.recorder_.site),
          plain_(recording.recorder_.plain) {
      recording.enter(reader);
      recording.recorder_.rate = rate;
      recording.recorder_.plain = false;
    }
    ~Stamp() {
      recording_.reader_ = reader_;
      recording_.recorder_.activation = activation_;
      recording_.recorder_.rate = rate_;
      recording_.recorder_.site = site_;
      recording_.recorder_.plain = plain_;
    }
    Stamp(const Stamp&) = delete;
    Stamp& operator=(const Stamp&) = delete;

   private:
    GraphRecording& recording_;
    std::uint32_t reader_;
    std::uint16_t activation_;
    RateIndex rate_;
    std::uint32_t site_;
    bool plain_;
  };

  // In the order of period and offset, so that numbers do not depend on the file's order.
  void add_rates() {
    std::vector<std::size_t> order(g_.rates.size() - 1);
    std::iota(order.begin(), order.end(), std::size_t{1});
    std::sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
      const std::uint32_t ta = g_.rates[a].trigger, tb = g_.rates[b].trigger;
      if (ta != 0 && tb != 0) return g_.activations[ta].path < g_.activations[tb].path;
      if (ta != 0 || tb != 0) return tb != 0;
      const int by_period = compare(g_.rates[a].period, g_.rates[b].period);
      return by_period != 0 ? by_period < 0 : g_.rates[a].offset < g_.rates[b].offset;
    });
    rates_.assign(g_.rates.size(), 0);
    for (const std::size_t i : order)
      rates_[i] = g_.rates[i].trigger != 0 ? recorder_.add_trigger()
                                           : recorder_.add_rate(g_.rates[i].period, g_.rates[i].offset);
  }

  void add_probe(const Probe& probe, Array& value) {
    const GraphNet& net = g_.nets[probe.net];
    const RateIndex rate = std::exchange(recorder_.rate, rate_of(net.rate));
    for (int i = 0; i < value.size(); ++i) {
      const std::string name = path_of(g_, net) + element_suffix(value.shape(), i);
      const auto number = [&](const char* what, double start) {
        result_.uses.push_back(ParameterUse::tunable);
        return recorder_.parameter(what + name, start, std::string(net.unit));
      };
      RecordedProbe probed{name, 0, value[i]};
      if (probe.open) probed.driver = value[i] * number("gain of ", 1);
      probed.parameter = static_cast<std::uint32_t>(recorder_.record.parameters.size());
      value[i] = probed.driver + number("probe of ", 0);
      probed_->push_back(std::move(probed));
    }
    recorder_.rate = rate;
  }

  // What a sampled block shows is held between its hits, also where it only hands on what it reads.
  void hold(Array& value, RateIndex rate) {
    for (int i = 0; i < value.size(); ++i) {
      if (value[i].is_known()) continue;
      const RecordedNode& node = recorder_.record.nodes[value[i].id()];
      const bool constant = node.op == Op::constant || node.op == Op::parameter;
      if (constant || (node.rate == rate && !is_leaf(node.op))) continue;
      value[i] = recorder_.operation(Op::copy, value[i], 0, 0);
    }
  }

  // ---- parameters

  // With what it depends on, without recursion.
  void record_parameter(std::uint32_t wanted) {
    std::vector<std::uint32_t> open{wanted};
    while (!open.empty()) {
      const std::uint32_t index = open.back();
      const GraphParameter& p = g_.parameters[index];
      bool ready = true;
      for (std::size_t i = 0; p.expression && i < p.expression.code->names.size(); ++i) {
        const Reference& r = g_.references[p.expression.first_reference + i];
        if (r.kind != Reference::Kind::parameter || parameter_done_[r.index]) continue;
        open.push_back(r.index);
        ready = false;
      }
      if (!ready) continue;
      open.pop_back();
      if (parameter_done_[index]) continue;
      record_one(index);
      parameter_done_[index] = 1;
    }
  }

  void record_one(std::uint32_t index) {
    const GraphParameter& p = g_.parameters[index];
    if (!p.expression) return;
    const std::uint16_t activation = std::exchange(recorder_.activation, std::uint16_t{0});
    const RateIndex rate = std::exchange(recorder_.rate, RateIndex{0});
    if (p.literal) {
      leaf(p, parameter_values_[index]);
    } else if (p.expression.code->tree->kind == Expression::Kind::vector) {
      parameter_values_[index] = partly_literal(p);
    } else {
      RecordedNames names(*this, p.expression);
      const std::uint32_t site = recorder_.site;
      if (!p.expression.code->is_name())
        recorder_.site = recorder_.add_site(path_of(g_, p), "parameter", p.expression.mark);
      parameter_values_[index] = evaluate(*p.expression.code, names);
      recorder_.site = site;
    }
    if (!p.reads_signals) parameter_values_[index] = parameter_values_[index].spread(p.shape);
    recorder_.rate = rate;
    recorder_.activation = activation;
    if (!p.of_scope) add_bounds(p, parameter_values_[index]);
  }

  Value one_leaf(const GraphParameter& p, std::string name, double value) {
    result_.uses.push_back(static_cast<ParameterUse>(p.structural));
    return recorder_.parameter(std::move(name), value, std::string(p.unit));
  }
  void leaf(const GraphParameter& p, Array& value) {
    value = Array(p.shape);
    const std::string path = path_of(g_, p);
    if (p.shape.is_scalar()) {
      value[0] = one_leaf(p, path, p.value[0].number());
      return;
    }
    for (int i = 0; i < value.size(); ++i)
      value[i] = one_leaf(p, path + element_suffix(p.shape, i), p.value[i].number());
  }

  // `[k, 2, 3]`: the numbers among the entries can be set, the others follow their expressions.
  Array partly_literal(const GraphParameter& p) {
    RecordedNames names(*this, p.expression);
    Array value = evaluate(*p.expression.code, names).spread(p.shape);
    int at = 0;
    bool regular = true;
    const auto mark_literals = [&](const Expression& list, const auto& again) -> void {
      for (const ExpressionPtr& entry : list.arguments) {
        if (entry->kind == Expression::Kind::vector) {
          again(*entry, again);
          continue;
        }
        const bool number =
            entry->kind == Expression::Kind::number ||
            (entry->kind == Expression::Kind::unary && entry->arguments[0]->kind == Expression::Kind::number);
        if (number && entry->text != "not" && at < value.size() && value[at].is_known()) {
          value[at] = one_leaf(p, path_of(g_, p) + element_suffix(p.shape, at), value[at].number());
        } else if (!number && entry->kind == Expression::Kind::name && entry->parts.size() == 1) {
          regular = regular && is_scalar_name(p, *entry);
        } else if (!number) {
          regular = regular && entry->kind != Expression::Kind::call;
        }
        if (!regular) return;  // where the next entry stands is not known
        ++at;
      }
    };
    mark_literals(*p.expression.code->tree, mark_literals);
    return value;
  }
  bool is_scalar_name(const GraphParameter& p, const Expression& node) {
    RecordedNames names(*this, p.expression);
    const Code& code = *p.expression.code;
    for (std::uint32_t i = 0; i < code.names.size(); ++i) {
      if (code.names[i] == &node) return names.shape(i).is_scalar();
    }
    return false;
  }

  void add_bounds(const GraphParameter& p, const Array& value) {
    if (p.min == -unbounded && p.max == unbounded && p.above == -unbounded) return;
    for (int i = 0; i < value.size(); ++i) {
      if (value[i].is_known()) continue;
      result_.bounds.push_back(
          {path_of(g_, p) + element_suffix(value.shape(), i), value[i], p.min, p.max, p.above, p.mark});
    }
  }

  // ---- nets that expressions drive

  void record_wire(std::uint32_t index, const std::string& path, std::string method, RateIndex rate) {
    const GraphNet& net = g_.nets[index];
    if (net.by_parameter) return bind_net(index, value_of_parameter(net.parameter));
    recorder_.rate = rate;
    if (!net.driver.code->is_name()) recorder_.site = recorder_.add_site(path, std::move(method), net.driver.mark);
    RecordedNames names(*this, net.driver);
    bind_net(index, evaluate(*net.driver.code, names));
  }

  void record_scope(std::uint32_t s) {
    const GraphScope& scope = g_.scopes[s];
    recorder_.plain = scope.plain;
    enter(scope.activation);
    for (std::uint32_t i = 0; i < scope.type->inputs.size() && scope.parent != nowhere; ++i) {
      const GraphNet& net = g_.nets[scope.first_input + i];
      record_wire(scope.first_input + i, scope.path, "wire " + scope.type->inputs[i].name, rate_of(net.rate));
    }
    for (std::uint32_t i = 0; i < scope.type->outputs.size() && scope.parent != nowhere; ++i) {
      const GraphNet& net = g_.nets[scope.first_output + i];
      record_wire(scope.first_output + i, scope.path, "output " + scope.type->outputs[i].name, rate_of(net.rate));
    }
  }

  std::vector<GraphBus> buses_in_order() const {
    std::vector<GraphBus> buses = g_.buses;
    std::sort(buses.begin(), buses.end(), [](const GraphBus& a, const GraphBus& b) { return a.path < b.path; });
    return buses;
  }

  void record_buses_and_copies() {
    for (const GraphBus& bus : buses_in_order()) {
      recorder_.plain = g_.scopes[bus.scope].plain;
      enter(g_.scopes[bus.scope].activation);
      for (std::uint32_t i = 0; i < bus.declaration->in.size(); ++i) {
        const std::uint32_t index = bus.first_member + i;
        record_wire(index, bus.path, "wire " + bus.declaration->in[i].port, rate_of(g_.nets[index].rate));
      }
    }
    for (const GraphRepeat& repeat : g_.repeats) {
      if (repeat.net == nowhere) continue;
      enter(g_.scopes[repeat.scope].activation);
      record_wire(repeat.net, repeat.path, "copies", 0);
    }
  }

  // ---- blocks

  void record_block(std::uint32_t index) {
    const GraphBlock& block = g_.blocks[index];
    recorder_.plain = !block.declaration->zero_crossing || g_.scopes[block.scope].plain;
    enter(block.activation);
    if (!block.type)
      return record_wire(block.first_output, block.path, "expression", rate_of(g_.nets[block.first_output].rate));
    const Block& kind = *block.type->block;
    const RateIndex rate = rate_of(block.rate);
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      const std::string_view port = kind.lists.empty() ? kind.inputs[i]->name : kind.lists[0]->name;
      record_wire(block.first_input + i, block.path, "wire " + std::string(port), rate);
    }
    instance_.begin(block);
    block_states_[index] = {instance_.first_state(), instance_.first_discrete()};
    const Now now;
    if (!kind.states.empty() || !kind.discretes.empty()) {
      recorder_.rate = 0;
      recorder_.activation = 0;  // initial values are asked for in any case
      recorder_.site = block_site(block, "initial");
      kind.initial(now, Init());
      enter(block.activation);
    }
    recorder_.rate = rate;
    recorder_.site = block_site(block, "outputs");
    kind.outputs(now, Out());
    if (!kind.states.empty()) {
      recorder_.site = block_site(block, "derivatives");
      kind.derivatives(now, Rates());
    }
    if (!kind.discretes.empty()) {
      recorder_.site = block_site(block, "update");
      kind.update(now, Next());
    }
    if (!kind.states.empty() || !kind.discretes.empty()) recorder_.site = block_site(block, "jumps");
    kind.jumps(now, Jumps());
    instance_.finish();
    if (recorder_.activation != 0) freeze_states(block_states_[index]);
  }

  // While a block is not active, its states stand still.
  void freeze_states(std::pair<std::uint32_t, std::uint32_t> first) {
    const Truth active(gates_[reader_]);
    Record& record = recorder_.record;
    const Stamp stamp(*this, 0, 0);
    for (std::uint32_t i = first.first; i < record.states.size(); ++i) {
      recorder_.site = record.states[i].site;
      record.states[i].derivative = where(active, record.states[i].derivative, Value(0));
    }
    for (std::uint32_t i = first.second; i < record.discretes.size(); ++i) {
      recorder_.site = record.discretes[i].site;
      recorder_.rate = record.discretes[i].rate;
      const Value next = where(active, record.discretes[i].next, recorder_.discrete(i));
      record.discretes[i].next = next;
    }
  }

  // ---- activations

  std::vector<std::uint32_t> activations_in_order() const {
    std::vector<std::uint32_t> order(g_.activations.size() - 1);
    std::iota(order.begin(), order.end(), 1U);
    std::sort(order.begin(), order.end(),
              [this](std::uint32_t a, std::uint32_t b) { return g_.activations[a].path < g_.activations[b].path; });
    return order;
  }

  // Whether each is enabled, as a value that changes at hits and events only.
  void record_conditions() {
    gates_.assign(g_.activations.size(), Value(1.0));
    gate_numbers_.assign(g_.activations.size(), 0);
    for (const std::uint32_t a : activations_in_order()) {
      const GraphActivation& activation = g_.activations[a];
      gates_[a] = gates_[activation.parent];
      if (activation.enable_when) {
        enter(activation.parent);
        recorder_.rate = 0;
        recorder_.plain = false;
        recorder_.site = recorder_.add_site(activation.path, "enable", activation.declaration->enable->mark);
        RecordedNames names(*this, activation.enable_when);
        const Array when = evaluate(*activation.enable_when.code, names);
        Truth any = Value(0.0) < when[0];
        for (int i = 1; i < when.size(); ++i) any = any || Value(0.0) < when[i];
        recorder_.activation = 0;
        gates_[a] = gates_[activation.parent].is(1) ? any.value() : (Truth(gates_[activation.parent]) && any).value();
      }
      if (gates_[a].is(1)) continue;
      gate_numbers_[a] = static_cast<std::uint16_t>(recorder_.record.activations.size());
      recorder_.record.activations.push_back(gates_[a]);
    }
    enter(0);
  }

  // What a net shows to those who are not active with it.
  Array held_outside(std::uint32_t index, std::uint32_t a) {
    const GraphActivation& activation = g_.activations[a];
    const GraphNet& net = g_.nets[index];
    Array value = value_of_net(index);
    // A trigger or a condition above decides whether there was an activation.
    std::uint32_t trigger = a;
    while (trigger != 0 && g_.activations[trigger].rate == 0) trigger = g_.activations[trigger].parent;
    const bool is_enabled = !gates_[a].is(1);
    if (trigger == 0 && !is_enabled) return value;
    const Stamp stamp(*this, 0, 0);
    recorder_.site = recorder_.add_site(activation.path, "outputs", net.mark);
    Truth shows(Value(1.0));
    if (trigger != 0) {
      recorder_.rate = rate_of({GraphRate::Kind::discrete, g_.activations[trigger].rate});
      shows = recorder_.hit(recorder_.rate) >= Value(0.0);
      recorder_.rate = 0;
    }
    // A triggered block keeps its outputs by itself.
    const bool by_enable = is_enabled && (activation.rate == 0 || activation.resets_outputs());
    if (by_enable) shows = trigger != 0 ? shows && Truth(gates_[a]) : Truth(gates_[a]);
    const Array initial = initial_outside(index, activation, value);
    Array result(value.shape());
    for (int i = 0; i < value.size(); ++i) {
      RecordedDiscrete held;
      held.name = path_of(g_, net) + element_suffix(value.shape(), i) + ".held";
      held.site = recorder_.site;
      held.initial = initial.at(i);
      recorder_.record.discretes.push_back(std::move(held));
      const auto state = static_cast<std::uint32_t>(recorder_.record.discretes.size() - 1);
      const Value kept = recorder_.discrete(state);
      recorder_.record.discretes[state].next = kept;
      result[i] = where(shows, value[i], kept);
      if (by_enable && !activation.resets_outputs()) recorder_.record.holds.push_back({shows.value(), value[i], state});
    }
    return result;
  }

  // Of an output what is declared; of what is inside, the value with which the run starts.
  Array initial_outside(std::uint32_t index, const GraphActivation& activation, const Array& value) {
    const GraphNet& net = g_.nets[index];
    const bool is_output = activation.owner.kind == GraphChild::Kind::scope
                               ? net.kind == GraphNet::Kind::scope_output
                               : net.kind == GraphNet::Kind::output || net.kind == GraphNet::Kind::expression;
    if (!is_output || net.owner != activation.owner.index || net.port >= activation.initials.size()) return value;
    const BoundExpression& initial = activation.initials[net.port];
    if (!initial) return value;
    RecordedNames names(*this, initial);
    return evaluate(*initial.code, names).spread(value.shape());
  }

  // The events `x.enable`, at which states may be reset, and `x.trigger`.
  void record_activation_jumps() {
    for (const std::uint32_t a : activations_in_order()) {
      const GraphActivation& activation = g_.activations[a];
      if (activation.enable_when && !gates_[a].is_known()) {
        const Stamp stamp(*this, 0, 0);
        RecordedJump jump;
        jump.name = activation.path + ".enable";
        jump.site = recorder_.site = recorder_.add_site(jump.name, "enable", activation.declaration->enable->mark);
        jump.function = gates_[a] - Value(0.5);
        jump.direction = 1;
        for (const auto& [other, state] : enabled_since_) {
          if (other == a) jump.assignments.push_back({true, state, recorder_.time()});
        }
        std::vector<RecordedJump> jumps{std::move(jump)};
        for (const std::uint32_t b : g_.order) {
          if (!activation.resets_states() || !g_.blocks[b].type || !is_within(g_, g_.blocks[b].activation, a)) continue;
          assign(g_.blocks[b], b, jumps, nullptr);
        }
        add_jumps(std::move(jumps));
      }
      if (activation.trigger_when) add_trigger(activation, gates_[a]);
    }
  }

  void add_trigger(const GraphActivation& activation, Value enabled) {
    const TriggerDecl& decl = *activation.declaration->trigger;
    const Stamp stamp(*this, activation.parent, rate_of_names(activation.trigger_when));
    recorder_.plain = true;
    recorder_.site = recorder_.add_site(activation.path, "trigger", decl.mark);
    RecordedNames names(*this, activation.trigger_when);
    const auto [function, at_zero] = crossing_of(*activation.trigger_when.code, names);
    for (int i = 0; i < function.size(); ++i) {
      RecordedJump jump;
      jump.name = activation.path + ".trigger" + element_suffix(function.shape(), i);
      jump.site = recorder_.site;
      jump.function = function[i];
      jump.at_zero = at_zero;
      jump.direction = decl.edge == "falling" ? -1 : decl.edge == "either" ? 0 : 1;
      jump.rate = recorder_.rate;
      jump.activation = recorder_.activation;
      jump.triggers = rate_of({GraphRate::Kind::discrete, activation.rate});
      jump.enabled = enabled;
      recorder_.record.jumps.push_back(std::move(jump));
    }
  }

  // ---- resets

  RateIndex rate_of_names(const BoundExpression& bound) const {
    RateIndex rate = 0;
    for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
      const Reference& r = g_.references[bound.first_reference + i];
      if (r.kind == Reference::Kind::time) return 0;
      if (r.kind != Reference::Kind::net || g_.nets[r.index].rate.kind == GraphRate::Kind::constant) continue;
      const RateIndex one = rate_of(g_.nets[r.index].rate);
      if (one == 0 || (rate != 0 && rate != one)) return 0;
      rate = one;
    }
    return rate;
  }

  // The jump of `reset:` without its assignments, one for each element of the condition.
  std::vector<RecordedJump> reset_jumps(const std::string& path, const BlockDecl& decl, const BoundExpression& when) {
    recorder_.rate = rate_of_names(when);
    recorder_.plain = true;
    recorder_.site = recorder_.add_site(path, "reset", decl.reset->mark);
    RecordedNames names(*this, when);
    const auto [function, at_zero] = crossing_of(*when.code, names);
    std::vector<RecordedJump> jumps;
    for (int i = 0; i < function.size(); ++i) {
      RecordedJump jump;
      jump.name = path + ".reset" + element_suffix(function.shape(), i);
      jump.site = recorder_.site;
      jump.function = function[i];
      jump.at_zero = at_zero;
      jump.direction = decl.reset->edge == "falling" ? -1 : decl.reset->edge == "either" ? 1 - 1 : 1;
      jump.rate = recorder_.rate;
      jump.activation = recorder_.activation;
      jumps.push_back(std::move(jump));
    }
    return jumps;
  }

  // Assigns a block's states in one jump, or element by element in as many jumps as there are elements.
  void assign(const GraphBlock& block, std::uint32_t index, std::vector<RecordedJump>& jumps, const Array* to) {
    const Block& kind = *block.type->block;
    std::uint32_t state = block_states_[index].first, discrete = block_states_[index].second, shape = block.first_shape;
    const auto one = [&](bool is_discrete) {
      const int size = g_.state_shapes[shape++].size();
      for (int i = 0; i < size; ++i) {
        const std::uint32_t at = is_discrete ? discrete++ : state++;
        const Value initial =
            is_discrete ? recorder_.record.discretes[at].initial : recorder_.record.states[at].initial;
        RecordedJump& jump = jumps.size() == 1 ? jumps[0] : jumps[static_cast<std::size_t>(i)];
        jump.assignments.push_back({is_discrete, at, to ? to->at(i) : initial});
      }
    };
    for (std::size_t i = 0; i < kind.states.size(); ++i) one(false);
    for (std::size_t i = 0; i < kind.discretes.size(); ++i) one(true);
  }

  void add_jumps(std::vector<RecordedJump> jumps) {
    for (RecordedJump& jump : jumps) recorder_.record.jumps.push_back(std::move(jump));
  }

  void record_reset(std::uint32_t index) {
    const GraphBlock& block = g_.blocks[index];
    if (!block.reset_when || !block.type) return;
    enter(block.activation);
    std::vector<RecordedJump> jumps = reset_jumps(block.path, *block.declaration, block.reset_when);
    if (block.reset_to) {
      RecordedNames names(*this, block.reset_to);
      const Array to = evaluate(*block.reset_to.code, names);
      assign(block, index, jumps, &to);
    } else {
      assign(block, index, jumps, nullptr);
    }
    add_jumps(std::move(jumps));
  }

  void record_scope_reset(std::uint32_t s) {
    const GraphScope& scope = g_.scopes[s];
    if (!scope.reset_when) return;
    enter(scope.activation);
    std::vector<RecordedJump> jumps = reset_jumps(scope.path, *scope.declaration, scope.reset_when);
    Array to;
    if (scope.reset_to) {
      RecordedNames names(*this, scope.reset_to);
      to = evaluate(*scope.reset_to.code, names);
    }
    for (const std::uint32_t b : g_.order) {
      std::uint32_t up = g_.blocks[b].scope;
      while (up != nowhere && up != s) up = g_.scopes[up].parent;
      if (up == s && g_.blocks[b].type) assign(g_.blocks[b], b, jumps, scope.reset_to ? &to : nullptr);
    }
    add_jumps(std::move(jumps));
  }

  // ---- names

  void list_signals() {
    std::vector<RecordedSignal>& signals = recorder_.record.signals;
    signals.reserve(g_.nets.size());
    const auto add = [&](std::uint32_t index) {
      const GraphNet& net = g_.nets[index];
      if (net.bus != nowhere) return;
      const Array& value = value_of_net(index);
      std::string path = path_of(g_, net);
      const RateIndex rate = rate_of(net.rate);
      if (value.is_scalar()) {
        signals.push_back({std::move(path), value[0], std::string(net.unit), rate});
        return;
      }
      for (int i = 0; i < value.size(); ++i) {
        signals.push_back({path + element_suffix(value.shape(), i), value[i], std::string(net.unit), rate});
      }
    };
    for (const std::uint32_t s : g_.scope_order) {
      if (g_.scopes[s].parent == nowhere) continue;
      for (std::uint32_t i = 0; i < g_.scopes[s].type->outputs.size(); ++i) add(g_.scopes[s].first_output + i);
      for (std::uint32_t i = 0; i < g_.scopes[s].type->inputs.size(); ++i) add(g_.scopes[s].first_input + i);
    }
    for (const GraphBus& bus : buses_in_order()) {
      for (std::uint32_t i = 0; i < bus.declaration->in.size(); ++i) add(bus.first_member + i);
    }
    for (const std::uint32_t b : g_.order) {
      for (std::uint32_t i = 0; i < g_.blocks[b].outputs; ++i) add(g_.blocks[b].first_output + i);
      for (std::uint32_t i = 0; i < g_.blocks[b].inputs; ++i) add(g_.blocks[b].first_input + i);
    }
  }

  RecordedGraph::Range add_columns(const std::string& name, const Array& value, const std::string& unit, RateIndex rate,
                                   bool written, const std::vector<std::string>& names = {}) {
    const RecordedGraph::Range range{static_cast<std::uint32_t>(result_.columns.size()),
                                     static_cast<std::uint32_t>(value.size())};
    for (int i = 0; i < value.size(); ++i) {
      result_.columns.push_back({name + element_suffix(value.shape(), i), value[i], unit, rate, written, names});
    }
    return range;
  }

  // What the numbers of a state machine's state are called.
  std::vector<std::string> state_names(const GraphNet& net) const {
    std::vector<std::string> names;
    if (net.kind != GraphNet::Kind::scope_output || net.port != 0) return names;
    if (const auto& machine = g_.scopes[net.owner].type->machine) {
      for (const StateMachineDecl::State& state : machine->states) names.push_back(state.name);
    }
    return names;
  }
  std::vector<std::string> state_names(const BoundExpression& bound) const {
    if (!bound.code->is_name()) return {};
    const Reference& r = g_.references[bound.first_reference];
    return r.kind == Reference::Kind::net && r.whole ? state_names(g_.nets[r.index]) : std::vector<std::string>{};
  }

  void show_columns() {
    std::unordered_map<std::string, RecordedGraph::Range> by_text;
    std::vector<Array> values(g_.shown.size());
    for (std::size_t i = 0; i < g_.shown.size(); ++i) {
      const GraphShown& shown = g_.shown[i];
      recorder_.rate = rate_of_names(shown.bound);
      if (!shown.bound.code->is_name()) {
        recorder_.site = recorder_.add_site(to_string(*shown.expression), "shown", shown.bound.mark);
      }
      RecordedNames names(*this, shown.bound);
      values[i] = evaluate(*shown.bound.code, names);
    }
    recorder_.rate = 0;
    for (const Graph::Column& column : g_.columns) {
      if (column.net != nowhere) {
        const GraphNet& net = g_.nets[column.net];
        by_text.emplace(column.name, add_columns(column.name, value_seen(column.net), std::string(net.unit),
                                                 rate_of(net.rate), true, state_names(net)));
        continue;
      }
      const GraphShown& shown = g_.shown[column.shown];
      const auto range = add_columns(column.name, values[column.shown], shown.unit, rate_of_names(shown.bound), true,
                                     state_names(shown.bound));
      by_text.emplace(to_string(*shown.bound.code->tree), range);
      result_.shown.emplace(shown.expression, range);
    }
    for (std::size_t i = 0; i < g_.shown.size(); ++i) {
      const GraphShown& shown = g_.shown[i];
      if (result_.shown.contains(shown.expression)) continue;
      const std::string text = to_string(*shown.bound.code->tree);
      auto [it, is_new] = by_text.try_emplace(text);
      if (is_new) {
        it->second = add_columns(to_string(*shown.expression), values[i], shown.unit, rate_of_names(shown.bound), false,
                                 state_names(shown.bound));
      }
      result_.shown.emplace(shown.expression, it->second);
    }
  }

  void record_numbers() {
    for (const auto& [expression, bound] : g_.numbers) {
      recorder_.site = recorder_.add_site(to_string(*expression), "number", bound.mark);
      RecordedNames names(*this, bound);
      const Array value = evaluate(*bound.code, names);
      if (value.is_scalar()) result_.numbers.emplace(expression, value[0]);
    }
  }

  const Graph& g_;
  Recorder recorder_;
  RecordedGraph result_;
  RecordingInstance instance_;
  const std::vector<Probe>& probes_;
  std::vector<RecordedProbe>* probed_;
  std::vector<Array> net_values_;
  std::vector<NetState> net_state_;
  std::vector<Array> parameter_values_;
  std::vector<std::uint8_t> parameter_done_;
  std::vector<RateIndex> rates_;
  std::uint32_t reader_ = 0;                 // the activation under which is recorded
  std::vector<Value> gates_;                 // per activation: whether it is enabled
  std::vector<std::uint16_t> gate_numbers_;  // its number in the Record; 0: always enabled
  std::unordered_map<std::uint32_t, Array> seen_;
  std::unordered_map<std::uint32_t, Value> elapsed_;
  std::unordered_map<std::uint32_t, Value> since_;                      // per activation
  std::vector<std::pair<std::uint32_t, std::uint32_t>> enabled_since_;  // the same: activation and discrete state
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      block_states_;  // first continuous and discrete state of each block
};

Shape RecordedNames::shape(std::uint32_t name) {
  const Reference& r = recording_.graph().references[bound_.first_reference + name];
  if (!r.whole) return r.last > 0 ? Shape::vector(r.last - r.first + 1) : Shape::scalar();
  if (r.kind == Reference::Kind::parameter) return recording_.graph().parameters[r.index].shape;
  if (r.kind == Reference::Kind::net) return recording_.graph().nets[r.index].shape;
  return Shape::scalar();
}

Array RecordedNames::value(std::uint32_t name) {
  const Reference& r = recording_.graph().references[bound_.first_reference + name];
  switch (r.kind) {
    case Reference::Kind::number:
      return {r.number};
    case Reference::Kind::time:
      return {recording_.recorder().time()};
    case Reference::Kind::parameter: {
      const Array& value = recording_.value_of_parameter(r.index);
      return r.whole ? value : element_of(value, r.first, r.last, r.column);
    }
    case Reference::Kind::elapsed:
      return {recording_.elapsed(r.index)};
    case Reference::Kind::net: {
      const Array& value = recording_.value_seen(r.index);
      return r.whole ? value : element_of(value, r.first, r.last, r.column);
    }
    case Reference::Kind::missing:
      break;
  }
  assert(!"a name without meaning is recorded");
  return {};
}

const Array* RecordedNames::known(std::uint32_t name) {
  const Reference& r = recording_.graph().references[bound_.first_reference + name];
  if (r.kind == Reference::Kind::number) return &(held_ = r.number);
  if (r.kind != Reference::Kind::parameter) return nullptr;
  const GraphParameter& p = recording_.graph().parameters[r.index];
  if (p.reads_signals) return nullptr;
  return &(held_ = r.whole ? p.value : element_of(p.value, r.first, r.last, r.column));
}

// ---- the instance

void RecordingInstance::begin(const GraphBlock& block) {
  stand_for(block);
  const Block& kind = *block.type->block;
  Recorder& recorder = recording_.recorder();
  Record& record = recorder.record;
  states_.clear(), discretes_.clear(), state_at_.clear(), discrete_at_.clear(), events_.clear();
  first_state_ = static_cast<std::uint32_t>(record.states.size());
  first_discrete_ = static_cast<std::uint32_t>(record.discretes.size());
  recorder.site = 0;
  recorder.rate = 0;
  const bool several = kind.states.size() + kind.discretes.size() > 1;
  const auto name_of_state = [&](std::string_view state, const Shape& shape, int i) {
    return (several ? fmt::format("{}.{}", block.path, state) : block.path) + element_suffix(shape, i);
  };
  const std::string_view unit = block.declaration->unit;
  if (kind.states.empty() && kind.discretes.empty()) return;
  const std::uint32_t site = recording_.block_site(block, "states");
  recorder.site = site;
  std::uint32_t at = block.first_shape;
  for (const State* s : kind.states) {
    const Shape& shape = graph_.state_shapes[at++];
    state_at_.push_back(static_cast<std::uint32_t>(record.states.size()));
    Array value(shape);
    for (int i = 0; i < shape.size(); ++i) {
      const auto index = static_cast<std::uint32_t>(record.states.size());
      record.states.push_back({name_of_state(s->name, shape, i), site, 0.0, s->spec.init,
                               std::string(!unit.empty() && !several ? unit : s->spec.unit)});
      value[i] = recorder.state(index);
    }
    states_.push_back(std::move(value));
  }
  for (const Discrete* s : kind.discretes) {
    const Shape& shape = graph_.state_shapes[at++];
    discrete_at_.push_back(static_cast<std::uint32_t>(record.discretes.size()));
    Array value(shape);
    for (int i = 0; i < shape.size(); ++i) {
      const auto index = static_cast<std::uint32_t>(record.discretes.size());
      RecordedDiscrete discrete;
      discrete.name = name_of_state(s->name, shape, i);
      discrete.site = site;
      discrete.rate = recording_.rate_of(block.rate);
      discrete.initial = s->spec.init;
      discrete.unit = std::string(!unit.empty() && !several ? unit : s->spec.unit);
      record.discretes.push_back(std::move(discrete));
      value[i] = recorder.discrete(index);
      record.discretes[index].next = value[i];  // what update() does not write stays
    }
    discretes_.push_back(std::move(value));
  }
}

Array RecordingInstance::sized(const Size& size, Array value) const {
  switch (size.kind) {
    case Size::Kind::elementwise:
    case Size::Kind::scalar:
      return value.size() == 1 ? value.spread(Shape::scalar()) : value;
    case Size::Kind::count:
      return value.spread(Shape::vector(size.count->value()));
    case Size::Kind::fixed:
      return value.spread(Shape::vector(size.fixed));
    case Size::Kind::any:
      break;
  }
  return value;
}

Array RecordingInstance::input(int index) {
  const auto i = static_cast<std::uint32_t>(index);
  return sized(block_->type->block->inputs[i]->spec.size, recording_.value_of_net(block_->first_input + i));
}

std::vector<Array> RecordingInstance::list(int) {
  std::vector<Array> entries;
  const Size& size = block_->type->block->lists[0]->spec.size;
  if (block_->reduces) {
    for (const Value& v : recording_.value_of_net(block_->first_input).values()) entries.emplace_back(v);
    return entries;
  }
  for (std::uint32_t i = 0; i < block_->inputs; ++i) {
    entries.push_back(sized(size, recording_.value_of_net(block_->first_input + i)));
  }
  return entries;
}

Array RecordingInstance::number(int index) {
  const NumberSpec& spec = block_->type->block->numbers[static_cast<std::size_t>(index)]->spec;
  const GraphParameter& p = parameter(static_cast<std::size_t>(index));
  assert(p.is_set && "a block reads an optional number that is not given");
  if (spec.structural) return sized(spec.size, p.value);
  return sized(spec.size, recording_.value_of_parameter(block_->first_parameter + static_cast<std::uint32_t>(index)));
}

Array RecordingInstance::table(int index) {
  const Block& kind = *block_->type->block;
  const TableSpec& spec = kind.tables[static_cast<std::size_t>(index)]->spec;
  const std::uint32_t at =
      block_->first_parameter + static_cast<std::uint32_t>(kind.numbers.size()) + static_cast<std::uint32_t>(index);
  const GraphParameter& p = graph_.parameters[at];
  assert(p.is_set && "a block reads an optional table that is not given");
  if (spec.structural) return p.value;
  Array value = recording_.value_of_parameter(at);
  if (spec.zeros_matter && !p.reads_signals) {
    for (int i = 0; i < value.size(); ++i) {
      if (p.value[i].is(0)) value[i] = 0.0;
    }
  }
  return value;
}

std::vector<Activity> RecordingInstance::activity(int) {
  std::vector<Activity> entries;
  for (std::uint32_t i = 0; i < block_->inputs; ++i) {
    const GraphNet& net = graph_.nets[block_->first_input + i];
    const Reference& writer = graph_.references[net.driver.first_reference];  // merge checks that it is a name
    entries.push_back(recording_.activity_of(activation_of(graph_, graph_.nets[writer.index])));
  }
  return entries;
}

Value RecordingInstance::hit() {
  const RateIndex rate = recording_.rate_of(block_->rate);
  return rate != 0 ? recording_.recorder().hit(rate) : Value(0);
}
Value RecordingInstance::period() {
  if (block_->rate.kind != GraphRate::Kind::discrete) return 0;
  const ClockRate& rate = graph_.rates[block_->rate.index];
  return rate.trigger != 0 ? recording_.elapsed(rate.trigger) : Value(rate.period.to_double());
}

Meeting RecordingInstance::meeting(int index) {
  const GraphNet& net = graph_.nets[block_->first_input + static_cast<std::uint32_t>(index)];
  if (net.by_parameter || net.rate.kind != GraphRate::Kind::discrete) return Meeting::never;
  if (block_->rate.kind != GraphRate::Kind::discrete) return Meeting::apart;
  if (net.rate.index == block_->rate.index) return Meeting::faster;
  const ClockRate &of_signal = graph_.rates[net.rate.index], &own = graph_.rates[block_->rate.index];
  if (of_signal.trigger != 0 || own.trigger != 0) return Meeting::apart;
  const auto fits = [](const ClockRate& fast, const ClockRate& slow) {
    const std::optional<Rational> shift = subtract(slow.offset, fast.offset);
    const std::optional<Rational> periods = divide(slow.period, fast.period);
    const std::optional<Rational> offsets = shift ? divide(*shift, fast.period) : std::nullopt;
    return periods && periods->den() == 1 && offsets && offsets->den() == 1;
  };
  return fits(of_signal, own) ? Meeting::faster : fits(own, of_signal) ? Meeting::slower : Meeting::apart;
}

Array RecordingInstance::earlier(int index, const Array& initial, bool steady) {
  Recorder& recorder = recording_.recorder();
  const GraphNet& net = graph_.nets[block_->first_input + static_cast<std::uint32_t>(index)];
  const Array signal = input(index);
  Array result(signal.shape());
  for (int i = 0; i < signal.size(); ++i) {
    RecordedDiscrete state;
    state.name = block_->path + element_suffix(signal.shape(), i);
    state.site = recorder.site;
    state.rate = recording_.rate_of(net.rate);
    state.initial = initial.at(i);
    state.next = signal[i];
    state.unit = std::string(net.unit);
    recorder.record.discretes.push_back(std::move(state));
    const auto at = static_cast<std::uint32_t>(recorder.record.discretes.size() - 1);
    result[i] = steady ? recorder.discrete(at) : recorder.discrete_before(at);
  }
  return result;
}

std::vector<Value> RecordingInstance::kernel(std::shared_ptr<const Kernel> kernel, std::vector<Value> inputs,
                                             std::vector<Value> advanced) {
  KernelUse use;
  use.kernel = std::move(kernel);
  for (const Value& v : inputs) use.inputs.push_back(recording_.recorder().id_of(v));
  for (const Value& v : advanced) use.advance_inputs.push_back(recording_.recorder().id_of(v));
  return recording_.recorder().kernel(std::move(use));
}

const Shape& RecordingInstance::state_shape(bool discrete, int index) const {
  const std::size_t before = discrete ? block_->type->block->states.size() : 0;
  return graph_.state_shapes[block_->first_shape + before + static_cast<std::size_t>(index)];
}
std::uint32_t RecordingInstance::state_index(bool discrete, int index) const {
  return discrete ? discrete_at_[static_cast<std::size_t>(index)] : state_at_[static_cast<std::size_t>(index)];
}

void RecordingInstance::write(Written what, int index, const Array& value) {
  Record& record = recording_.recorder().record;
  if (what == Written::output) {
    recording_.bind_net(block_->first_output + static_cast<std::uint32_t>(index), value);
    return;
  }
  const bool discrete = what == Written::next || what == Written::initial_discrete;
  const Array spread = value.spread(state_shape(discrete, index));
  const std::uint32_t first = state_index(discrete, index);
  for (int i = 0; i < spread.size(); ++i) {
    const std::size_t at = first + static_cast<std::size_t>(i);
    if (what == Written::derivative) record.states[at].derivative = spread[i];
    if (what == Written::initial_state) record.states[at].initial = spread[i];
    if (what == Written::next) record.discretes[at].next = spread[i];
    if (what == Written::initial_discrete) record.discretes[at].initial = spread[i];
  }
}

int RecordingInstance::event(const Crossing& crossing) {
  events_.push_back({crossing.function,
                     crossing.direction,
                     crossing.of_slope,
                     crossing.of_kernel,
                     {},
                     recording_.recorder().site,
                     crossing.level,
                     crossing.name});
  return static_cast<int>(events_.size() - 1);
}

void RecordingInstance::jump(int event, bool discrete, int index, const Array& value) {
  events_[static_cast<std::size_t>(event)].assignments.push_back(
      {discrete, index, value.spread(state_shape(discrete, index))});
}

void RecordingInstance::finish() {
  Record& record = recording_.recorder().record;
  const std::size_t count = events_.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Event& event = events_[k];
    // A scalar function moves all elements of a state, a vector each its own.
    for (int i = 0; i < event.function.size(); ++i) {
      RecordedJump jump;
      const std::string name = !event.name.empty() ? event.name : count == 1 ? "jump" : fmt::format("jump{}", k + 1);
      jump.name = block_->path + "." + name + element_suffix(event.function.shape(), i);
      jump.site = event.site;
      jump.function = event.function[i];
      jump.direction = event.direction == Direction::rising ? 1 : event.direction == Direction::falling ? -1 : 0;
      jump.of_slope = event.of_slope;
      jump.of_kernel = event.of_kernel;
      jump.level = event.level;
      jump.rate = recording_.rate_of(block_->rate);
      jump.activation = recording_.recorder().activation;
      for (const Assignment& a : event.assignments) {
        const std::uint32_t first = state_index(a.discrete, a.index);
        for (int e = 0; e < a.value.size(); ++e) {
          if (event.function.size() > 1 && e != i) continue;
          jump.assignments.push_back({a.discrete, first + static_cast<std::uint32_t>(e), a.value[e]});
        }
      }
      record.jumps.push_back(std::move(jump));
    }
  }
}

}  // namespace

RecordedGraph record(const Graph& graph, const std::vector<Probe>& probes, std::vector<RecordedProbe>* probed) {
  return GraphRecording(graph, probes, probed).run();
}

}  // namespace plantloop
