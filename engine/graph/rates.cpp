// Rates (S6): which blocks run continuously, which at the hits of a clock, which only when parameters change.
//
// Kinds only ever rise, constant < discrete < continuous, and a clock only gets faster, so the fixed point does not
// depend on the order of visits. Sources are decided last, all at once, by what reads them.

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/graph/elaboration.h"
#include "engine/graph/static_instance.h"

namespace plantloop {
namespace {

// A whole number of times.
bool divides(const Rational& fast, const Rational& slow) {
  const std::optional<Rational> ratio = divide(slow, fast);
  return ratio && ratio->den() == 1;
}

class RateFinding {
 public:
  explicit RateFinding(Elaboration& e) : e_(e), g_(e.g), nets_(static_cast<std::uint32_t>(e.g.nets.size())) {}

  void run() {
    read_stated_rates();
    readers_ = find_readers(g_);
    queued_.assign(nets_ + g_.blocks.size(), 0);
    decided_source_.assign(g_.blocks.size(), 0);
    push_all();
    work();
    decide_sources();
    push_all();
    work();
    if (decide_watchers()) {
      push_all();
      work();
    }
    verify();
  }

 private:
  // ---- what is stated

  void read_stated_rates() {
    for (GraphScope& scope : g_.scopes) {
      if (scope.parent == nowhere) continue;
      const std::uint16_t around = g_.scopes[scope.parent].rate;
      const bool own = scope.declaration->trigger || scope.declaration->period;
      scope.rate = own ? own_rate(*scope.declaration, scope.parent, scope.activation, around) : around;
    }
    stated_.assign(g_.blocks.size(), 0);
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) {
      GraphBlock& block = g_.blocks[i];
      const BlockDecl& decl = *block.declaration;
      const std::uint16_t around = g_.scopes[block.scope].rate;
      const bool own = decl.trigger || decl.period;
      stated_[i] = own ? own_rate(decl, block.scope, block.activation, around) : around;
      block.bad |= own && stated_[i] == 0;  // reported
      if (stated_[i] != 0)
        block.rate_reason = decl.trigger ? "of its trigger" : decl.period ? "stated" : "of the subsystem around it";
      take_own_period(i);
    }
  }

  // The period that a block brings along counts as stated; another one beside it is an error.
  void take_own_period(std::uint32_t i) {
    GraphBlock& block = g_.blocks[i];
    if (!block.type || block.bad) return;
    StaticInstance instance(g_);
    instance.stand_for(block);
    const std::string text = block.type->block->own_period();
    if (text.empty()) return;
    const BlockDecl& decl = *block.declaration;
    const std::optional<Rational> period = Rational::from_text(text);
    if (!period) return;
    if (!decl.period) {
      stated_[i] = number_of(*period, Rational(), decl.mark);
      block.rate_reason = "of its model file";
    } else if (stated_[i] != 0 && !(g_.rates[stated_[i]].period == *period)) {
      e_.findings
          .error(decl.period->mark, "the model file of '{}' was made for a period of {} s, not {} s", decl.name, text,
                 shortest(g_.rates[stated_[i]].period.to_double()))
          .hint("leave `rate:` out, the file gives it")
          .named("rate");
      block.bad = true;
    }
  }

  // The rate of `trigger:` or `rate:`; 0 after reporting.
  std::uint16_t own_rate(const BlockDecl& decl, std::uint32_t scope, std::uint32_t activation, std::uint16_t around) {
    if (decl.trigger && decl.period) {
      e_.findings.error(decl.rate_mark, "'{}' runs when it is triggered: it cannot have a rate too", decl.name)
          .also(decl.trigger->mark, "its trigger")
          .named("rate");
      return 0;
    }
    if (around != 0 && g_.rates[around].trigger != 0) {
      e_.findings
          .error(decl.trigger ? decl.trigger->mark : decl.rate_mark,
                 "'{}' stands inside '{}', which runs when it is triggered: it cannot have a {} of its own", decl.name,
                 g_.activations[g_.rates[around].trigger].path, decl.trigger ? "trigger" : "rate")
          .named("rate");
      return 0;
    }
    if (!decl.trigger) return stated(decl, scope);
    if (g_.rates.size() > 60000) {
      e_.findings.error(decl.trigger->mark, "a diagram may have up to 60000 different rates");
      return 0;
    }
    g_.rates.push_back({{}, {}, decl.trigger->mark, activation});
    return g_.activations[activation].rate = static_cast<std::uint16_t>(g_.rates.size() - 1);
  }

  // The number of a declared rate; 0 after reporting.
  std::uint16_t stated(const BlockDecl& decl, std::uint32_t scope) {
    const std::optional<Rational> period = exact(decl.period, scope, "period");
    std::optional<Rational> offset = Rational();
    if (decl.offset) offset = exact(decl.offset, scope, "offset");
    if (!period || !offset) return 0;
    if (period->is_zero() || period->is_negative()) {
      e_.findings.error(decl.period->mark, "a period must be greater than 0 s, got {}", shortest(period->to_double()))
          .named("rate");
      return 0;
    }
    if (offset->is_negative()) {
      e_.findings.error(decl.offset->mark, "an offset must not be negative, got {}", shortest(offset->to_double()))
          .named("rate");
      return 0;
    }
    return number_of(*period, *offset, decl.rate_mark);
  }

  std::uint16_t number_of(const Rational& period, const Rational& offset, const Mark& mark) {
    for (std::size_t i = 1; i < g_.rates.size(); ++i) {
      const ClockRate& known = g_.rates[i];
      if (known.trigger == 0 && known.period == period && known.offset == offset) return static_cast<std::uint16_t>(i);
    }
    if (g_.rates.size() > 60000) {
      e_.findings.error(mark, "a diagram may have up to 60000 different rates");
      return 0;
    }
    g_.rates.push_back({period, offset, mark, 0});
    return static_cast<std::uint16_t>(g_.rates.size() - 1);
  }

  // Decimals, + - * / and parameters that are such.
  std::optional<Rational> exact(const ExpressionPtr& tree, std::uint32_t scope, const char* what) {
    BoundExpression bound = e_.bind(tree, scope);
    if (!resolve(e_, bound, Context::parameter)) return {};
    for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
      const Reference& r = g_.references[bound.first_reference + i];
      if (r.kind == Reference::Kind::parameter && g_.parameters[r.index].bad) return {};
    }
    mark_structural(g_, bound, 2);
    const std::optional<Rational> value = exact_value(bound);
    if (value) return value;
    BoundNames names(g_, bound);
    const std::optional<double> number = known_number(*bound.code, 0, bound.code->steps.size(), names);
    Finding& finding = e_.findings.error(
        tree->mark, "a {} must be exact: decimal numbers with + - * / and parameters that are such", what);
    if (number) finding.hint(fmt::format("write its value, {}", shortest(*number)));
    finding.named("rate");
    return {};
  }

  std::optional<Rational> exact_value(const BoundExpression& bound, int depth = 0) {
    std::vector<Rational> stack;
    for (const Step& s : bound.code->steps) {
      std::optional<Rational> result;
      switch (s.kind) {
        case Step::Kind::number:
          result = Rational::from_text(s.node->text);
          break;
        case Step::Kind::name: {
          const Reference& r = g_.references[bound.first_reference + s.name];
          if (r.kind == Reference::Kind::parameter && r.whole && depth < 200 && g_.parameters[r.index].expression) {
            result = exact_value(g_.parameters[r.index].expression, depth + 1);
          }
          break;
        }
        case Step::Kind::unary:
          if (s.op == Op::neg) result = subtract(Rational(), stack.back()), stack.pop_back();
          break;
        case Step::Kind::binary: {
          const Rational b = stack.back();
          stack.pop_back();
          const Rational a = stack.back();
          stack.pop_back();
          if (s.op == Op::add) result = add(a, b);
          if (s.op == Op::sub) result = subtract(a, b);
          if (s.op == Op::mul) result = multiply(a, b);
          if (s.op == Op::div) result = divide(a, b);
          break;
        }
        default:
          break;
      }
      if (!result) return {};
      stack.push_back(*result);
    }
    return stack.size() == 1 ? std::optional(stack.back()) : std::nullopt;
  }

  // ---- inherited rates

  void push(std::uint32_t item) {
    if (queued_[item]) return;
    queued_[item] = 1;
    queue_.push_back(item);
  }
  void push_all() {
    for (std::uint32_t i = 0; i < nets_; ++i) {
      if (g_.nets[i].driver) push(i);
    }
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) {
      if (g_.blocks[i].type) push(nets_ + i);
    }
  }
  void work() {
    while (!queue_.empty()) {
      const std::uint32_t item = queue_.front();
      queue_.pop_front();
      queued_[item] = 0;
      if (item < nets_) {
        set_net(item, rate_of_net(g_.nets[item]));
      } else {
        rate_block(item - nets_);
      }
    }
  }

  void set_net(std::uint32_t index, GraphRate rate) {
    if (g_.nets[index].rate == rate) return;
    g_.nets[index].rate = rate;
    for (const std::uint32_t reader : readers_.of(index)) push(reader);
  }

  static GraphRate clock(std::uint16_t index) { return {GraphRate::Kind::discrete, index}; }

  // Rules (a) to (e) for one more input.
  GraphRate combine(GraphRate a, GraphRate b) const {
    if (a.kind < b.kind) std::swap(a, b);
    if (a.kind != GraphRate::Kind::discrete || b.kind != GraphRate::Kind::discrete || a.index == b.index) return a;
    return is_faster(b.index, a.index) ? b : a;
  }
  bool is_faster(std::uint16_t a, std::uint16_t b) const {
    const std::uint32_t ta = g_.rates[a].trigger, tb = g_.rates[b].trigger;
    if (ta != 0 && tb != 0) return g_.activations[ta].path < g_.activations[tb].path;
    if (ta != 0 || tb != 0) return tb != 0;
    const int order = compare(g_.rates[a].period, g_.rates[b].period);
    return order != 0 ? order < 0 : g_.rates[a].offset < g_.rates[b].offset;
  }

  GraphRate rate_of_names(const BoundExpression& bound) const {
    GraphRate rate;
    for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
      const Reference& r = g_.references[bound.first_reference + i];
      if (r.kind == Reference::Kind::time) return {GraphRate::Kind::continuous, 0};
      if (r.kind == Reference::Kind::elapsed) rate = combine(rate, clock(g_.activations[r.index].rate));
      if (r.kind == Reference::Kind::net) rate = combine(rate, g_.nets[r.index].rate);
    }
    return rate;
  }

  GraphRate rate_of_net(const GraphNet& net) const {
    switch (net.kind) {
      case GraphNet::Kind::expression:
        if (stated_[net.owner] != 0) return clock(stated_[net.owner]);
        break;
      case GraphNet::Kind::scope_input:
      case GraphNet::Kind::scope_output:
        if (net.by_parameter) return {};
        if (g_.scopes[net.owner].rate != 0) return clock(g_.scopes[net.owner].rate);
        break;
      default:
        break;
    }
    return rate_of_names(net.driver);
  }

  void rate_block(std::uint32_t index) {
    GraphBlock& block = g_.blocks[index];
    const RateKind kind = block.type->block->rate_kind();
    GraphRate rate;
    if (kind == RateKind::continuous) {
      rate.kind = GraphRate::Kind::continuous;
    } else if (stated_[index] != 0) {
      rate = clock(stated_[index]);
    } else if (kind == RateKind::source) {
      if (!decided_source_[index]) return;
      rate = block.rate;
    } else {
      for (std::uint32_t i = 0; i < block.inputs; ++i) rate = combine(rate, g_.nets[block.first_input + i].rate);
      if (is_merge(block) && has_several_clocks(block)) rate = {GraphRate::Kind::continuous, 0};
      if (rate.kind != GraphRate::Kind::constant) block.rate_reason = "from its inputs";
      if (kind == RateKind::watching && rate.kind == GraphRate::Kind::constant && decided_source_[index]) {
        rate.kind = GraphRate::Kind::continuous;
        block.rate_reason = "it watches the time";
      }
    }
    block.rate = rate;
    for (std::uint32_t i = 0; i < block.outputs; ++i) set_net(block.first_output + i, rate);
  }

  // Of entries that run at different instants each counts from its own on.
  static bool is_merge(const GraphBlock& block) { return block.type->name == "merge"; }
  bool has_several_clocks(const GraphBlock& block) const {
    std::uint16_t first = 0;
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      const GraphRate rate = g_.nets[block.first_input + i].rate;
      if (rate.kind != GraphRate::Kind::discrete) continue;
      if (first != 0 && rate.index != first) return true;
      first = rate.index;
    }
    return false;
  }

  // ---- sources (f)

  void decide_sources() {
    std::vector<std::pair<std::uint32_t, std::uint16_t>> decided;
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) {
      const GraphBlock& block = g_.blocks[i];
      if (!block.type || stated_[i] != 0 || block.type->block->rate_kind() != RateKind::source) continue;
      decided.emplace_back(i, clock_of_readers(i));
    }
    for (const auto& [index, rate] : decided) {
      GraphBlock& block = g_.blocks[index];
      decided_source_[index] = 1;
      block.rate = rate != 0 ? clock(rate) : GraphRate{GraphRate::Kind::continuous, 0};
      block.rate_reason = rate != 0 ? "from its readers" : "a source";
    }
  }

  // Blocks that watch the time although nothing that they read changes.
  bool decide_watchers() {
    bool any = false;
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) {
      const GraphBlock& block = g_.blocks[i];
      if (!block.type || block.type->block->rate_kind() != RateKind::watching) continue;
      if (block.rate.kind == GraphRate::Kind::constant) decided_source_[i] = any = true;
    }
    return any;
  }

  // The one clock of all blocks that read a source, also through others that only it feeds; 0: none.
  std::uint16_t clock_of_readers(std::uint32_t source) const {
    std::vector<std::uint32_t> open;
    std::unordered_set<std::uint32_t> seen;
    std::uint16_t found = 0;
    const auto follow = [&](std::uint32_t net) {
      for (const std::uint32_t reader : readers_.of(net)) {
        if (seen.insert(reader).second) open.push_back(reader);
      }
    };
    const auto outputs = [&](const GraphBlock& block) {
      for (std::uint32_t i = 0; i < block.outputs; ++i) follow(block.first_output + i);
    };
    outputs(g_.blocks[source]);
    while (!open.empty()) {
      const std::uint32_t item = open.back();
      open.pop_back();
      if (item < nets_ && g_.nets[item].kind == GraphNet::Kind::block_input) {
        follow(item);  // its block decides
        continue;
      }
      const GraphRate rate = item < nets_ ? g_.nets[item].rate : g_.blocks[item - nets_].rate;
      if (rate.kind == GraphRate::Kind::continuous) return 0;
      if (rate.kind == GraphRate::Kind::discrete) {
        if (found != 0 && found != rate.index) return 0;
        found = rate.index;
      } else if (item < nets_) {
        follow(item);
      } else {
        outputs(g_.blocks[item - nets_]);
      }
    }
    return found;
  }

  // ---- what is wrong

  void verify() {
    const std::size_t errors = e_.findings.report().error_count();
    for (std::uint32_t i = 0; i < nets_; ++i) {
      GraphNet& net = g_.nets[i];
      if (net.bad || !net.driver || net.by_parameter) continue;
      const bool of_scope = net.kind == GraphNet::Kind::scope_input || net.kind == GraphNet::Kind::scope_output;
      const bool is_stated = net.kind == GraphNet::Kind::expression    ? stated_[net.owner] != 0
                             : net.kind == GraphNet::Kind::block_input ? decides_itself(net.owner)
                             : of_scope                                ? g_.scopes[net.owner].rate != 0
                                                                       : net.kind == GraphNet::Kind::copies;
      if (!is_stated && net.rate.kind == GraphRate::Kind::discrete) {
        std::vector<std::uint32_t> inputs;
        for (std::size_t k = 0; k < net.driver.code->names.size(); ++k) {
          const Reference& r = g_.references[net.driver.first_reference + k];
          if (r.kind == Reference::Kind::net) inputs.push_back(r.index);
        }
        const bool of_block = net.kind == GraphNet::Kind::block_input;
        verify_mixture(inputs, net.rate.index, net.mark, of_block ? g_.blocks[net.owner].path : path_of(g_, net));
      }
    }
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) verify_block(i);
    if (e_.findings.report().error_count() == errors) note_reads_across();
  }

  // Rule (c), and blocks of a stated rate: reads across rates are legal without a block between, and seen.
  void note_reads_across() {
    struct Reads {
      std::uint16_t own, other;
      Mark mark;
      std::vector<std::string> signals;
    };
    std::map<std::string, Reads> by_reader;
    for (std::uint32_t i = 0; i < nets_; ++i) {
      const GraphNet& net = g_.nets[i];
      if (net.bad || !net.driver || net.by_parameter || net.kind == GraphNet::Kind::copies) continue;
      const bool of_block = net.kind == GraphNet::Kind::block_input;
      if (of_block && says_how_it_reads(g_.blocks[net.owner])) continue;
      const GraphRate own = of_block ? g_.blocks[net.owner].rate : net.rate;
      if (!is_clock(own)) continue;
      for (std::size_t k = 0; k < net.driver.code->names.size(); ++k) {
        const Reference& r = g_.references[net.driver.first_reference + k];
        if (r.kind != Reference::Kind::net) continue;
        const GraphRate other = g_.nets[r.index].rate;
        if (!is_clock(other) || other.index == own.index) continue;
        const std::string name = of_block ? g_.blocks[net.owner].path : path_of(g_, net);
        Reads& reads = by_reader.try_emplace(name, Reads{own.index, other.index, net.mark, {}}).first->second;
        const std::string signal = path_of(g_, g_.nets[r.index]);
        if (std::find(reads.signals.begin(), reads.signals.end(), signal) == reads.signals.end())
          reads.signals.push_back(signal);
      }
    }
    for (const auto& [name, reads] : by_reader) {
      const ClockRate &own = g_.rates[reads.own], &other = g_.rates[reads.other];
      const int order = compare(own.period, other.period);
      const std::string more =
          reads.signals.size() > 1 ? fmt::format(", and {} more", reads.signals.size() - 1) : std::string();
      e_.findings
          .check("rate-mix", reads.mark, "'{}' runs every {} and {} '{}', which runs every {}{}", name, text_of(own),
                 order > 0   ? "samples"
                 : order < 0 ? "holds"
                             : "reads",
                 reads.signals.front(), text_of(other), more)
          .hint("it takes the present value; a rate_transition in between would say with which latency");
    }
  }
  bool is_clock(const GraphRate& rate) const {
    return rate.kind == GraphRate::Kind::discrete && g_.rates[rate.index].trigger == 0;
  }
  static bool says_how_it_reads(const GraphBlock& block) {
    return block.type && (block.type->name == "rate_transition" || block.type->name == "zero_order_hold");
  }

  // Whether a block samples or holds what it reads by a rate of its own.
  bool decides_itself(std::uint32_t index) const {
    return stated_[index] != 0 || g_.blocks[index].type->block->rate_kind() == RateKind::continuous;
  }

  // Rule (d).
  void verify_mixture(const std::vector<std::uint32_t>& inputs, std::uint16_t fastest, const Mark& mark,
                      const std::string& name) {
    for (const std::uint32_t net : inputs) {
      const GraphRate rate = g_.nets[net].rate;
      if (rate.kind != GraphRate::Kind::discrete || rate.index == fastest) continue;
      const ClockRate& fast = g_.rates[fastest];
      const ClockRate& slow = g_.rates[rate.index];
      const std::optional<Rational> shift = subtract(slow.offset, fast.offset);
      const bool clocks = fast.trigger == 0 && slow.trigger == 0;
      if (clocks && divides(fast.period, slow.period) && shift && divides(fast.period, *shift)) continue;
      e_.findings.error(mark, "'{}' reads signals of mixed rates: {} and {}", name, text_of(fast), text_of(slow))
          .also(slow.mark, fmt::format("{}, for '{}'", text_of(slow), path_of(g_, g_.nets[net])))
          .hint(suggested_rate(fast, slow, name))
          .named("mixed-rates");
      return;
    }
  }
  // At the greatest common divisor every change of both is seen.
  static std::string suggested_rate(const ClockRate& fast, const ClockRate& slow, const std::string& name) {
    const std::string other = "put a zero_order_hold with a rate in between";
    if (fast.trigger != 0 || slow.trigger != 0) return fmt::format("give '{}' a rate of its own, or {}", name, other);
    std::optional<Rational> common = gcd(fast.period, slow.period);
    const std::optional<Rational> shift = subtract(slow.offset, fast.offset);
    if (common && shift && !shift->is_zero()) common = gcd(*common, *shift);
    if (!common) return fmt::format("give '{}' a rate of its own, or {}", name, other);
    const auto text = [](const Rational& r) {
      std::string decimal = shortest(r.to_double());
      const std::optional<Rational> again = Rational::from_text(decimal);
      return again && *again == r ? decimal : r.to_string();
    };
    std::string rate = text(*common);
    if (!fast.offset.is_zero()) {
      // Hits before the first of both are not needed; the remainder lies on the same grid.
      Rational offset = fast.offset;
      const double turns = std::floor(offset.to_double() / common->to_double());
      const std::optional<Rational> whole = Rational::make(static_cast<std::int64_t>(turns));
      const std::optional<Rational> product = whole ? multiply(*common, *whole) : std::nullopt;
      if (product) offset = subtract(offset, *product).value_or(offset);
      if (!offset.is_zero()) rate = fmt::format("{{period: {}, offset: {}}}", rate, text(offset));
    }
    return fmt::format("give '{}' a rate of its own, rate: {} sees every change of both; or {}", name, rate, other);
  }

  std::string text_of(const ClockRate& rate) const {
    if (rate.trigger != 0) return fmt::format("the trigger of '{}'", g_.activations[rate.trigger].path);
    const std::string period = shortest(rate.period.to_double()) + " s";
    return rate.offset.is_zero() ? period
                                 : fmt::format("{} with offset {} s", period, shortest(rate.offset.to_double()));
  }

  void verify_block(std::uint32_t index) {
    GraphBlock& block = g_.blocks[index];
    if (!block.type || block.bad) return;
    const RateKind kind = block.type->block->rate_kind();
    const BlockDecl& decl = *block.declaration;
    if (kind == RateKind::continuous && stated_[index] != 0) {
      const std::string rate = text_of(g_.rates[stated_[index]]);
      Finding& finding =
          decl.period
              ? e_.findings.error(decl.rate_mark, "{} is continuous: it cannot run at a rate", title_of(g_, block))
          : g_.rates[stated_[index]].trigger != 0
              ? e_.findings.error(decl.mark, "{} is continuous: it cannot run at {}", title_of(g_, block), rate)
              : e_.findings.error(decl.mark, "{} is continuous: it cannot stand inside a subsystem that runs every {}",
                                  title_of(g_, block), rate);
      if (block.type->name == "integrator") finding.hint("the sampled one is discrete_integrator");
      finding.named("rate");
      return;
    }
    if (stated_[index] != 0) return;
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      if (g_.nets[block.first_input + i].bad) return;
    }
    if (block.type->name == "rate_transition") {
      // That of its input would make it a block without effect.
      const std::uint16_t readers = clock_of_readers(index);
      const bool known = readers != 0 && g_.rates[readers].trigger == 0 && readers != block.rate.index;
      const ClockRate rate = known ? g_.rates[readers] : ClockRate{};
      e_.findings.error(decl.mark, "{} needs the rate of what reads it", title_of(g_, block))
          .hint(!known ? std::string("write rate: 0.1 beside type:, the period in s")
                : rate.offset.is_zero()
                    ? fmt::format("write rate: {} beside type:", shortest(rate.period.to_double()))
                    : fmt::format("write rate: {{period: {}, offset: {}}} beside type:",
                                  shortest(rate.period.to_double()), shortest(rate.offset.to_double())))
          .named("no-rate");
      return;
    }
    if (kind == RateKind::discrete && block.rate.kind != GraphRate::Kind::discrete) {
      e_.findings.error(decl.mark, "{} is sampled and needs a rate", title_of(g_, block))
          .hint("write rate: 0.1 beside type:, or on the subsystem around it; the number is the period in s")
          .named("no-rate");
      return;
    }
    if (block.rate.kind != GraphRate::Kind::discrete) return;
    std::vector<std::uint32_t> inputs;
    for (std::uint32_t i = 0; i < block.inputs; ++i) inputs.push_back(block.first_input + i);
    verify_mixture(inputs, block.rate.index, decl.mark, decl.name);
  }

  Elaboration& e_;
  Graph& g_;
  std::uint32_t nets_;
  Readers readers_;
  std::vector<std::uint16_t> stated_;
  std::vector<std::uint8_t> decided_source_, queued_;
  std::deque<std::uint32_t> queue_;
};

}  // namespace

void find_rates(Elaboration& e) { RateFinding(e).run(); }

}  // namespace plantloop
