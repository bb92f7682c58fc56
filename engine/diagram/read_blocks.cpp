// `blocks:`: instances and expression blocks.

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

constexpr std::string_view instance_keys[] = {"type",  "in",   "rate", "reset", "enable", "trigger",       "repeat",
                                              "first", "last", "doc",  "unit",  "label",  "zero_crossing", "priority"};

// The parts of one wire: of a sequence its entries, else the one expression.
bool read_wire(const Node& node, WireDecl& wire, Report& report) {
  wire.is_sequence = node.is_sequence();
  if (node.is_sequence() && !node.items.empty()) {
    bool complete = true;
    for (const Node& item : node.items) {
      wire.items.push_back(parse_expression(item, report));
      complete = complete && wire.items.back();
    }
    return complete;
  }
  wire.items.push_back(parse_expression(node, report));
  return wire.items.back() != nullptr;
}

// What a wire without a port shows, as one tree.
ExpressionPtr joined(const WireDecl& wire, const Mark& mark) {
  if (!wire.is_sequence) return wire.items.front();
  auto tree = std::make_shared<Expression>();
  tree->kind = Expression::Kind::vector;
  tree->arguments = wire.items;
  tree->mark = mark;
  return tree;
}

class BlockReader {
 public:
  explicit BlockReader(Report& report) : report_(report) {}

  BlockDecl read(const std::string& name, const Mark& mark, Node& node) {
    block_ = BlockDecl{};
    block_.name = name;
    block_.mark = mark;
    check_name(name, mark, "block", report_);
    switch (node.kind) {
      case Node::Kind::null:
        report_.error(mark, "block '{}' is empty", name)
            .hint("a block is an expression, r - y, or a mapping, {type: ..., in: ...}")
            .named("missing-key");
        break;
      case Node::Kind::scalar:
      case Node::Kind::sequence:
        read_expression(node);
        break;
      case Node::Kind::mapping:
        read_mapping(node);
        break;
    }
    return std::move(block_);
  }

 private:
  void read_expression(const Node& node) {
    block_.type = "expression";
    block_.type_mark = node.mark;
    WireDecl wire;
    wire.mark = node.mark;
    if (!read_wire(node, wire, report_)) return;
    block_.expression = joined(wire, node.mark);
    block_.in.push_back(std::move(wire));
  }

  void read_mapping(Node& node) {
    const Node* expr = node.find("expr");
    const Node* type = node.find("type");
    if (expr && !type) return read_long_expression(node, *expr);
    for (std::size_t i = 0; i < node.keys.size(); ++i) {
      read_key(node.keys[i], node.key_marks[i], node.items[i]);
    }
    if (type || node.find("<<")) return;
    Finding& finding = report_.error(block_.mark, "block '{}' has no type", block_.name).named("missing-key");
    const std::string near = nearest("type", node.keys);
    if (!near.empty())
      finding.hint(fmt::format("did you mean 'type' where '{}' stands?", near));
    else
      finding.hint("a block is an expression, r - y, or a mapping, {type: ..., in: ...}");
  }

  void read_long_expression(Node& node, const Node& expr) {
    for (std::size_t i = 0; i < node.keys.size(); ++i) {
      const std::string& key = node.keys[i];
      if (key == "expr") continue;
      if (key == "in" || key == "reset" || !is_instance_key(key)) {
        report_.error(node.key_marks[i], "block '{}' is an expression and has no key '{}'", block_.name, key)
            .suggest(key, {"expr", "rate", "unit", "doc", "label", "enable", "trigger"})
            .named("unknown-key");
        continue;
      }
      read_key(key, node.key_marks[i], node.items[i]);
    }
    read_expression(expr);
  }

  void read_key(const std::string& key, const Mark& mark, Node& value) {
    if (key == "<<") return;  // reported with the document
    if (!is_instance_key(key)) {
      if (key == "expr") {
        report_.error(mark, "block '{}' has both a type and an expression", block_.name)
            .hint("expr: belongs to a block without type; a block with type takes its signals by in:")
            .named("unknown-key");
        return;
      }
      block_.fields.push_back({key, mark, std::move(value)});
      return;
    }
    const auto text = [&] {
      return require_text(value, fmt::format("'{}'", key), report_) ? value.text : std::string();
    };
    if (key == "type") {
      block_.type = text();
      block_.type_mark = value.mark;
    } else if (key == "in") {
      read_wires(value, block_.in);
    } else if (key == "rate") {
      read_rate(value, mark);
    } else if (key == "reset") {
      read_reset(value, mark);
    } else if (key == "doc") {
      block_.doc = text();
      plain_text(value, "'doc'", report_);
    } else if (key == "label") {
      block_.label = text();
      plain_text(value, "'label'", report_);
    } else if (key == "unit") {
      block_.unit = text();
      if (value.is_scalar()) check_unit(value, report_);
    } else if (key == "zero_crossing") {
      const bool is_off = value.is_scalar() && value.text == "off";
      const bool is_on = value.is_scalar() && value.text == "on";
      block_.zero_crossing = is_on || (!is_off && to_boolean(value, key, true, report_));
    } else if (key == "priority") {
      const long least = std::numeric_limits<int>::min();
      const long most = std::numeric_limits<int>::max();
      block_.priority = static_cast<int>(std::clamp(to_integer(value, key, report_).value_or(0), least, most));
    } else if (key == "enable") {
      read_enable(value, mark);
    } else if (key == "trigger") {
      read_trigger(value, mark);
    } else if (key == "repeat") {
      block_.repeat = parse_expression(value, report_);
      block_.repeat_mark = mark;
    } else {
      std::optional<EndDecl>& end = key == "first" ? block_.first : block_.last;
      end.emplace();
      end->mark = mark;
      read_wires(value, end->wires);
    }
  }

  void read_wires(const Node& value, std::vector<WireDecl>& wires) {
    if (value.is_mapping()) {
      for (std::size_t i = 0; i < value.keys.size(); ++i) {
        WireDecl wire{.port = value.keys[i], .mark = value.key_marks[i], .items = {}, .is_sequence = false};
        if (value.items[i].kind == Node::Kind::null) {
          report_.error(wire.mark, "nothing is wired to '{}'", wire.port).named("missing-key");
        } else if (read_wire(value.items[i], wire, report_)) {
          wires.push_back(std::move(wire));
        }
      }
      return;
    }
    const bool empty = value.kind == Node::Kind::null || (value.is_sequence() && value.items.empty());
    if (empty) {
      report_.error(value.mark, "nothing is wired to block '{}'", block_.name).named("missing-key");
      return;
    }
    WireDecl wire;
    wire.mark = value.mark;
    if (read_wire(value, wire, report_)) wires.push_back(std::move(wire));
  }

  void read_rate(const Node& value, const Mark& mark) {
    block_.rate_mark = mark;
    if (!value.is_mapping()) {
      if (value.is_scalar()) {
        block_.period = parse_expression(value, report_);
        return;
      }
      report_
          .error(value.mark, "a rate is a period, 0.1, or {{period: 0.1, offset: 0.02}}; here is {}", describe(value))
          .named("kind");
      return;
    }
    const Section rate(value, "a rate", {"period", "offset"}, report_);
    rate.require("period", mark, "rate: {period: 0.1, offset: 0.02}");
    block_.period = rate.expression("period");
    block_.offset = rate.expression("offset");
  }

  void read_reset(const Node& value, const Mark& mark) {
    if (!value.is_mapping()) {
      report_.error(value.mark, "a reset is a mapping, here is {}", describe(value))
          .hint("for example reset: {when: h <= 0, to: 0}")
          .named("kind");
      return;
    }
    const Section section(value, "a reset", {"when", "edge", "to"}, report_);
    ResetDecl reset;
    reset.mark = mark;
    if (!section.require("when", mark, "reset: {when: h <= 0, to: 0}")) return;
    reset.when = section.expression("when");
    reset.edge = section.choice("edge", {"rising", "falling", "either"}, "rising");
    reset.to = section.expression("to");
    if (reset.when) block_.reset = std::move(reset);
  }

  void read_enable(const Node& value, const Mark& mark) {
    EnableDecl enable;
    enable.mark = mark;
    if (value.is_mapping()) {
      const Section section(value, "enable", {"when", "states", "outputs", "initial"}, report_);
      if (section.require("when", value.mark, "enable: {when: armed > 0.5}")) enable.when = section.expression("when");
      enable.resets_states = section.choice("states", {"held", "reset"}, "held") == "reset";
      enable.resets_outputs = section.choice("outputs", {"held", "reset"}, "held") == "reset";
      enable.initial = section.expression("initial");
    } else {
      enable.when = parse_expression(value, report_);
    }
    if (enable.when) block_.enable = std::move(enable);
  }

  void read_trigger(const Node& value, const Mark& mark) {
    const Section section(value, "a trigger", {"when", "edge", "initial"}, report_);
    TriggerDecl trigger;
    trigger.mark = mark;
    if (section.require("when", value.mark, "trigger: {when: clock > 0.5, edge: rising}"))
      trigger.when = section.expression("when");
    trigger.edge = section.choice("edge", {"rising", "falling", "either"}, "rising");
    trigger.initial = section.expression("initial");
    if (trigger.when) block_.trigger = std::move(trigger);
  }

  Report& report_;
  BlockDecl block_;
};

}  // namespace

bool is_instance_key(std::string_view key) {
  return std::find(std::begin(instance_keys), std::end(instance_keys), key) != std::end(instance_keys);
}

std::vector<BlockDecl> read_blocks(Node& node, Report& report) {
  std::vector<BlockDecl> blocks;
  if (!node.is_mapping()) {
    Finding& finding =
        report.error(node.mark, "'blocks' is a mapping from names to blocks, here is {}", describe(node)).named("kind");
    if (node.is_sequence()) finding.hint("every block has a name, and no dash before it: y: {type: gain, in: u}");
    if (node.is_scalar() && node.text.find(':') != std::string::npos) finding.hint("a space is missing after ':'");
    return blocks;
  }
  blocks.reserve(node.items.size());
  BlockReader reader(report);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool entry_below =
        i + 1 < node.items.size() && (is_instance_key(node.keys[i + 1]) || node.keys[i + 1] == "expr");
    if (node.items[i].kind == Node::Kind::null && entry_below) {
      report
          .error(node.key_marks[i + 1], "'{}' stands in the same column as block '{}'", node.keys[i + 1], node.keys[i])
          .hint(fmt::format("what belongs to '{}' is indented deeper than its name", node.keys[i]))
          .named("yaml");
      return blocks;
    }
    const std::size_t errors = report.error_count();
    blocks.push_back(reader.read(node.keys[i], node.key_marks[i], node.items[i]));
    blocks.back().bad = report.error_count() > errors;
  }
  return blocks;
}

}  // namespace plantloop
