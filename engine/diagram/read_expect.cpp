// `expect:`: what a run should show.

#include <algorithm>
#include <vector>

#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

constexpr std::string_view bounds[] = {"max", "min", "max_abs", "rms", "final"};

void print(const Node& node, std::string& out) {
  const auto open = [&](char bracket) { out += bracket; };
  switch (node.kind) {
    case Node::Kind::null:
      break;
    case Node::Kind::scalar:
      out += node.text;
      break;
    case Node::Kind::sequence:
    case Node::Kind::mapping: {
      const bool mapping = node.is_mapping();
      open(mapping ? '{' : '[');
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        if (i > 0) out += ", ";
        if (mapping) out.append(node.keys[i]).append(": ");
        print(node.items[i], out);
      }
      open(mapping ? '}' : ']');
    }
  }
}

std::string printed(const Node& node) {
  std::string out;
  print(node, out);
  return out;
}

class EntryReader {
 public:
  EntryReader(const Node& node, Report& report)
      : node_(node),
        report_(report),
        section_(node, "an expectation", {"signal",   "event", "at",    "value",   "between", "side",  "max",  "min",
                                          "max_abs",  "rms",   "final", "measure", "below",   "above", "step", "band",
                                          "baseline", "from",  "until", "abs",     "rel",     "count", "shift"},
                 report) {}

  bool read(ExpectDecl& expect) {
    if (!section_) return false;
    const std::size_t before = report_.error_count();
    expect.mark = node_.mark;
    expect.text = printed(node_);
    read_kind(expect);
    expect.signal = section_.expression("signal");
    expect.from = section_.expression("from");
    expect.until = section_.expression("until");
    expect.abs = section_.expression("abs");
    expect.rel = section_.expression("rel");
    expect.shift = section_.expression("shift");
    if (has("shift") && !has("baseline")) {
      report_.error(section_.mark_of("shift"), "'shift' has meaning beside 'baseline' only").named("unknown-key");
    }
    return report_.error_count() == before;
  }

 private:
  bool has(std::string_view key) const { return section_.find(key) != nullptr; }

  // Which of the forms it is; a form's keys beside another form are reported.
  void read_kind(ExpectDecl& expect) {
    std::vector<std::string> forms;
    for (const std::string_view form : {"at", "measure", "baseline", "event"}) {
      if (has(form)) forms.emplace_back(form);
    }
    for (const std::string_view form : bounds) {
      if (has(form)) forms.emplace_back(form);
    }
    if (forms.size() != 1) {
      say_form(forms);
      return;
    }
    const std::string& form = forms.front();
    if (form == "event") return read_event(expect);
    if (!has("signal") && form != "baseline") {
      report_.error(node_.mark, "an expectation needs 'signal'")
          .hint("for example {signal: y, at: 3, value: 1, abs: 1e-3}")
          .named("missing-key");
    }
    if (form == "at") return read_point(expect);
    if (form == "measure") return read_measure(expect);
    if (form == "baseline") {
      expect.measure = form;
      expect.baseline = section_.text("baseline");
      return misplaced({"value", "between", "below", "above", "side", "step", "band", "count"}, form);
    }
    read_bound(expect, form);
  }

  void say_form(const std::vector<std::string>& forms) {
    if (forms.empty() && section_.has_unknown_keys()) return;  // reported, one of them is meant
    if (forms.empty()) {
      report_.error(node_.mark, "this expectation says nothing about its signal")
          .hint("it needs one of: at, max, min, max_abs, rms, final, measure, baseline, event")
          .named("missing-key");
      return;
    }
    report_.error(section_.mark_of(forms[1]), "an expectation has only one of '{}' and '{}'", forms[0], forms[1])
        .hint("write two entries")
        .named("unknown-key");
  }

  void misplaced(std::initializer_list<std::string_view> keys, std::string_view form) {
    for (const std::string_view key : keys) {
      if (!has(key)) continue;
      report_.error(section_.mark_of(key), "'{}' has no meaning beside '{}'", key, form).named("unknown-key");
    }
  }

  void read_between(ExpectDecl& expect) {
    const Node* node = section_.find("between");
    if (!node) return;
    if (!node->is_sequence() || node->items.size() != 2) {
      report_.error(node->mark, "'between' is two numbers, [lower, upper]; here is {}", describe(*node)).named("kind");
      return;
    }
    expect.lower = parse_expression(node->items[0], report_);
    expect.upper = parse_expression(node->items[1], report_);
  }

  void read_value(ExpectDecl& expect) {
    expect.value = section_.expression("value");
    if (has("value")) return;
    for (const std::string_view key : {"abs", "rel"}) {
      if (has(key)) {
        report_.error(section_.mark_of(key), "'{}' is the tolerance of 'value', which is not given", key)
            .named("unknown-key");
      }
    }
  }

  void read_point(ExpectDecl& expect) {
    expect.measure = "at";
    expect.at = section_.expression("at");
    expect.side = section_.choice("side", {"left", "right"}, "right");
    if (has("value") == has("between")) {
      report_.error(section_.mark_of("at"), "'at' needs either 'value' or 'between'")
          .hint("for example {signal: y, at: 3, value: 1, abs: 1e-3} or between: [0.9, 1.1]")
          .named("missing-key");
    }
    read_value(expect);
    read_between(expect);
    misplaced({"below", "above", "step", "band", "count", "from", "until"}, "at");
  }

  // `max: 3` is a bound. `final: 1, abs: 1e-3` is a value with its tolerance.
  void read_bound(ExpectDecl& expect, const std::string& form) {
    expect.measure = form;
    const bool tolerance = has("abs") || has("rel");
    ExpressionPtr number = section_.expression(form);
    if (form == "final" || tolerance)
      expect.value = std::move(number);
    else if (form == "min")
      expect.lower = std::move(number);
    else
      expect.upper = std::move(number);
    misplaced({"value", "between", "below", "above", "side", "step", "band", "count"}, form);
  }

  void read_measure(ExpectDecl& expect) {
    expect.measure = section_.choice(
        "measure", {"max", "min", "max_abs", "rms", "final", "overshoot", "settling_time", "rise_time"}, "");
    if (expect.measure.empty()) return;
    const bool of_step =
        expect.measure == "overshoot" || expect.measure == "settling_time" || expect.measure == "rise_time";
    if (!has("value") && !has("below") && !has("above")) {
      report_.error(section_.mark_of("measure"), "'measure' needs 'value', 'below' or 'above'")
          .hint("for example {signal: y, measure: rms, below: 0.1}")
          .named("missing-key");
    }
    read_value(expect);
    expect.upper = section_.expression("below");
    expect.lower = section_.expression("above");
    if (has("value") && (has("below") || has("above"))) {
      report_.error(section_.mark_of("value"), "a measure has either 'value' or bounds").named("unknown-key");
    }
    if (of_step) {
      read_step(expect);
      expect.band = section_.expression("band");
    } else {
      misplaced({"step", "band"}, expect.measure);
    }
    misplaced({"between", "side", "count"}, "measure");
  }

  void read_step(ExpectDecl& expect) {
    const Node* node = section_.find("step");
    if (!node) {
      report_.error(section_.mark_of("measure"), "'{}' needs 'step'", expect.measure)
          .hint("for example step: {at: 1, from: 0, to: 1}")
          .named("missing-key");
      return;
    }
    const Section step(*node, "a step", {"at", "until", "from", "to"}, report_);
    for (const std::string_view key : {"at", "from", "to"})
      step.require(key, node->mark, "step: {at: 1, from: 0, to: 1}");
    expect.step_at = step.expression("at");
    expect.step_until = step.expression("until");
    expect.step_from = step.expression("from");
    expect.step_to = step.expression("to");
  }

  void read_event(ExpectDecl& expect) {
    expect.measure = "count";
    expect.event = section_.text("event");
    if (const auto count = section_.find("count"))
      expect.value = parse_expression(*count, report_);
    else {
      report_.error(section_.mark_of("event"), "'event' needs 'count'")
          .hint("for example {event: h.reset, count: 4}")
          .named("missing-key");
    }
    misplaced({"signal", "value", "between", "below", "above", "side", "step", "band"}, "event");
  }

  const Node& node_;
  Report& report_;
  Section section_;
};

}  // namespace

std::vector<ExpectDecl> read_expect(const Node& node, Report& report) {
  std::vector<ExpectDecl> list;
  if (!node.is_sequence()) {
    report.error(node.mark, "'expect' is a list, here is {}", describe(node))
        .hint("for example - {signal: y, at: 3, value: 1, abs: 1e-3}")
        .named("kind");
    return list;
  }
  for (const Node& item : node.items) {
    ExpectDecl expect;
    if (EntryReader(item, report).read(expect)) list.push_back(std::move(expect));
  }
  return list;
}

}  // namespace plantloop
