// `figures:`: whatever the tables of words allow (engine/diagram/figure_words.h).

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/colors.h"
#include "engine/base/numbers.h"
#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

using Kind = FigureWord::Kind;

class Reader {
 public:
  Reader(const PlotWords& plots, Report& report) : plots_(plots), report_(report) {}

  FigureDecl figure(const std::string& name, const Mark& mark, const Node& node) {
    FigureDecl figure;
    figure.name = name;
    figure.mark = mark;
    check_name(name, mark, "figure", report_);
    const Section section(node, fmt::format("figure '{}'", name), figure_words().names(), report_);
    section.require("panels", mark, "panels: [{y: [r, y], label: \"position [m]\"}]");
    figure.says = entries(node, figure_words());
    const Node* panels = section.find("panels");
    if (panels && panels->is_sequence() && panels->items.empty())
      report_.error(section.mark_of("panels"), "figure '{}' has no panels", name).named("missing-key");
    return figure;
  }

 private:
  const PlotWords& plots_;
  Report& report_;

  static bool has_plots(const FigureWords& words) { return &words == &panel_words() || &words == &inset_words(); }

  const FigureWord* word_of(const FigureWords& words, std::string_view key) const {
    if (const FigureWord* word = words.find(key)) return word;
    if (!has_plots(words)) return nullptr;
    const auto plot = std::find_if(plots_.begin(), plots_.end(), [&](const FigureWord& p) { return p.name == key; });
    return plot == plots_.end() ? nullptr : &*plot;
  }

  // A mapping whose keys are words; says what is unknown and what is missing.
  FigureBlock block(const Node& node, const FigureWords& words, std::string what) {
    std::vector<std::string> keys = words.names();
    if (has_plots(words))
      for (const FigureWord& plot : plots_) keys.emplace_back(plot.name);
    const Section section(node, std::move(what), keys, report_);
    if (!section) return {&words, node.mark, {}};
    FigureBlock made = entries(node, words);
    check(section, made);
    return made;
  }

  FigureBlock entries(const Node& node, const FigureWords& words) {
    FigureBlock made{&words, node.mark, {}};
    if (!node.is_mapping()) return made;
    for (std::size_t i = 0; i < node.keys.size(); ++i)
      if (const FigureWord* word = word_of(words, node.keys[i])) made.entries.push_back(entry(node.items[i], *word));
    return made;
  }

  // What must stand in a block of this kind.
  void check(const Section& section, const FigureBlock& made) {
    const FigureWords& words = *made.words;
    if (has_plots(words)) {
      const bool plots = std::any_of(made.entries.begin(), made.entries.end(),
                                     [](const FigureEntry& e) { return e.word->kind == Kind::plot; });
      if (!plots && !section.has_unknown_keys())
        section.require("y", made.mark, words.find("insets") ? "panels: [{y: [r, y]}]" : "{y: y}");
      check_labels(section, made);
    }
    if (&words == &curve_words()) section.require("signal", made.mark, "{signal: y, label: position}");
    if (&words == &line_words() && !made.find("x") == !made.find("y"))
      report_.error(made.mark, "a line has either x or y")
          .hint("for example {y: 1.5, label: limit}")
          .named("missing-key");
    if (&words == &band_words() && !made.find("from") && !made.find("until")) {
      section.require("lower", made.mark, "{lower: 0.98, upper: 1.02}");
      section.require("upper", made.mark, "{lower: 0.98, upper: 1.02}");
    }
    if (&words == &remark_words()) {
      section.require("x", made.mark, "{x: 1.2, y: 0.8, label: peak}");
      section.require("y", made.mark, "{x: 1.2, y: 0.8, label: peak}");
    }
    for (const auto& [scale, limits] :
         {std::pair{"scale", "limits"}, {"right_scale", "right_limits"}, {"x_scale", "x_limits"}})
      check_logarithmic(made, scale, limits);
    for (const FigureWord& word : words.words) {
      const bool replaceable = word.kind != Kind::choice && !word.choices.empty();
      if (replaceable && section.has_unknown_keys()) continue;
      const bool replaced = replaceable && std::any_of(word.choices.begin(), word.choices.end(),
                                                       [&](auto other) { return made.find(other); });
      if (word.needed && !replaced)
        section.require(word.name, made.mark, fmt::format("{}: ... ({})", word.name, word.doc));
    }
  }

  void check_labels(const Section& section, const FigureBlock& made) {
    const FigureEntry* labels = made.find("labels");
    const Node* curves = section.find("y");
    if (!labels || !curves) return;
    const std::size_t n = curves->is_sequence() ? curves->items.size() : 1;
    if (labels->texts.size() == n) return;
    report_
        .error(labels->mark, "'labels' has one text for each entry of 'y', {} in all; here is {}", n,
               describe(*section.find("labels")))
        .named("kind");
  }

  FigureEntry entry(const Node& node, const FigureWord& word) {
    FigureEntry made;
    made.word = &word;
    made.mark = node.mark;
    const std::string key = fmt::format("'{}'", word.name);
    switch (word.kind) {
      case Kind::text:
        if (require_text(node, key, report_)) made.text = plain_text(node, key, report_);
        break;
      case Kind::texts:
        read_texts(node, word, made);
        break;
      case Kind::number:
        made.numbers = {number(node, word)};
        break;
      case Kind::numbers:
        read_numbers(node, word, made);
        break;
      case Kind::limits:
        read_limits(node, word, made);
        break;
      case Kind::flag:
        made.flag = to_boolean(node, word.name, false, report_);
        break;
      case Kind::choice:
        made.text = to_choice(node, word.name, word.choices, report_);
        break;
      case Kind::color:
        read_color(node, word, made);
        break;
      case Kind::signal:
        made.signal = parse_expression(node, report_);
        break;
      case Kind::signals:
        read_signals(node, word, made);
        break;
      case Kind::column:
      case Kind::grid:
        read_column(node, word, made);
        break;
      case Kind::axis:
        if (node.is_scalar())
          made.text = plain_text(node, key, report_);
        else
          made.parts.push_back(block(node, *word.parts, "the x axis"));
        break;
      case Kind::list:
        read_list(node, word, made);
        break;
      case Kind::plot:
        for (const Node* item : one_or_all(node))
          made.parts.push_back(block(*item, *word.parts, std::string(word.name)));
        break;
    }
    return made;
  }

  static std::vector<const Node*> one_or_all(const Node& node) {
    if (!node.is_sequence()) return {&node};
    std::vector<const Node*> all;
    for (const Node& item : node.items) all.push_back(&item);
    return all;
  }

  // Numbers that are written as such are held to their bounds here.
  ExpressionPtr number(const Node& node, const FigureWord& word) {
    ExpressionPtr tree = parse_expression(node, report_);
    const std::optional<double> written = plain(tree);
    if (!written) return tree;
    const double value = *written;
    const bool fits = value >= word.least && value <= word.most && (!word.whole || value == static_cast<long>(value));
    if (fits) return tree;
    const std::string kind = word.whole ? "a whole number" : "a number";
    const std::string range = word.most < 1e300 ? fmt::format("from {:g} to {:g}", word.least, word.most)
                                                : fmt::format("of at least {:g}", word.least);
    report_.error(node.mark, "'{}' is {} {}; here is {}", word.name, kind, range, describe(node)).named("range");
    return nullptr;
  }

  void read_texts(const Node& node, const FigureWord& word, FigureEntry& made) {
    for (const Node* item : one_or_all(node)) {
      const std::string what = fmt::format("an entry of '{}'", word.name);
      if (require_text(*item, what, report_)) made.texts.push_back(plain_text(*item, what, report_));
    }
  }

  void read_numbers(const Node& node, const FigureWord& word, FigureEntry& made) {
    if (!node.is_sequence() || node.items.size() != word.count) {
      report_.error(node.mark, "'{}' are {} numbers, {}; here is {}", word.name, word.count, word.doc, describe(node))
          .named("kind");
      return;
    }
    for (const Node& item : node.items) made.numbers.push_back(parse_expression(item, report_));
  }

  void read_limits(const Node& node, const FigureWord& word, FigureEntry& made) {
    if (!node.is_sequence() || node.items.size() != 2) {
      report_.error(node.mark, "'{}' are two numbers, [lower, upper]; here is {}", word.name, describe(node))
          .named("kind");
      return;
    }
    for (const Node& item : node.items) {
      const bool open = item.is_scalar() && item.text == "auto";
      made.numbers.push_back(open ? nullptr : parse_expression(item, report_));
    }
    const std::optional<double> lower = plain(made.numbers[0]), upper = plain(made.numbers[1]);
    if (lower && upper && !(*lower < *upper))
      report_
          .error(node.mark, "'{}' are [lower, upper] in rising order; here is [{:g}, {:g}]", word.name, *lower, *upper)
          .named("range");
  }

  // The value of a number that is written as such.
  static std::optional<double> plain(const ExpressionPtr& tree) {
    const bool negative = tree && tree->kind == Expression::Kind::unary && tree->text == "-";
    const Expression* number = negative ? tree->arguments[0].get() : tree.get();
    if (!number || number->kind != Expression::Kind::number) return std::nullopt;
    return negative ? -number->number : number->number;
  }

  // A logarithmic axis has no place for zero.
  void check_logarithmic(const FigureBlock& made, std::string_view scale, std::string_view limits) {
    const FigureEntry* ends = made.find(limits);
    if (made.text(scale) != "log" || !ends) return;
    for (const ExpressionPtr& end : ends->numbers) {
      const std::optional<double> value = plain(end);
      if (!value || *value > 0) continue;
      report_.error(ends->mark, "a logarithmic axis has only values greater than 0, and '{}' has {:g}", limits, *value)
          .hint("'scale: symlog' has room for zero and below; or 'auto' in its place")
          .named("range");
      return;
    }
  }

  void read_color(const Node& node, const FigureWord& word, FigureEntry& made) {
    if (node.is_scalar() && color_number(node.text)) {
      made.text = node.text;
      return;
    }
    const std::vector<std::string> names(word.choices.begin(), word.choices.end());
    Finding& finding = report_.error(node.mark, "'{}' is a colour: {}, or \"#RRGGBB\"; here is {}", word.name,
                                     fmt::join(names.begin(), names.end(), ", "), describe(node));
    finding.named("choice");
    const std::string near = node.is_scalar() ? nearest(node.text, names) : std::string();
    if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
  }

  void read_signals(const Node& node, const FigureWord& word, FigureEntry& made) {
    if (node.is_sequence() && node.items.empty())
      report_.error(node.mark, "a panel shows at least one signal").named("missing-key");
    for (const Node* item : one_or_all(node)) {
      FigureBlock curve{word.parts, item->mark, {}};
      if (item->is_mapping()) {
        curve = block(*item, *word.parts, "a curve");
      } else {
        curve.entries.push_back(entry(*item, *word.parts->find("signal")));
      }
      made.parts.push_back(std::move(curve));
    }
  }

  void read_column(const Node& node, const FigureWord& word, FigureEntry& made) {
    const bool grid = word.kind == Kind::grid;
    const bool rows = node.is_sequence() && !node.items.empty() && node.items[0].is_sequence();
    const bool is_number = node.is_scalar() && parse_number(node.text);
    if (grid && rows) {
      made.columns = node.items[0].items.size();
      for (const Node& row : node.items) {
        if (!row.is_sequence() || row.items.size() != made.columns) {
          report_
              .error(row.mark, "every row of '{}' has {} numbers like the first; here is {}", word.name, made.columns,
                     describe(row))
              .named("kind");
          return;
        }
        for (const Node& item : row.items) made.numbers.push_back(parse_expression(item, report_));
      }
    } else if (!grid && (node.is_sequence() || is_number)) {
      for (const Node* item : one_or_all(node)) made.numbers.push_back(parse_expression(*item, report_));
    } else if (node.is_mapping()) {
      report_
          .error(node.mark, "'{}' is {}, here is a mapping", word.name,
                 grid ? "rows of numbers or signals" : "a list of numbers or a signal")
          .named("kind");
    } else {
      made.signal = parse_expression(node, report_);
    }
  }

  void read_list(const Node& node, const FigureWord& word, FigureEntry& made) {
    if (!node.is_sequence()) {
      report_.error(node.mark, "'{}' is a list, here is {}", word.name, describe(node)).named("kind");
      return;
    }
    for (const Node& item : node.items) made.parts.push_back(block(item, *word.parts, std::string(word.parts->what)));
  }
};

// Walks all blocks of a figure.
template <typename Visit>
void visit(const FigureBlock& block, const Visit& visit_entry) {
  for (const FigureEntry& entry : block.entries) {
    visit_entry(entry);
    for (const FigureBlock& part : entry.parts) visit(part, visit_entry);
  }
}

}  // namespace

const PlotWords& no_plots() {
  static const PlotWords none;
  return none;
}

const FigureEntry* FigureBlock::find(std::string_view name) const {
  for (const FigureEntry& entry : entries)
    if (entry.word->name == name) return &entry;
  return nullptr;
}

std::string FigureBlock::text(std::string_view name) const {
  const FigureEntry* entry = find(name);
  return entry ? entry->text : std::string();
}

bool FigureBlock::flag(std::string_view name) const {
  const FigureEntry* entry = find(name);
  return entry && entry->flag;
}

ExpressionPtr FigureBlock::number(std::string_view name) const {
  const FigureEntry* entry = find(name);
  return entry && !entry->numbers.empty() ? entry->numbers[0] : nullptr;
}

const std::vector<FigureBlock>& FigureBlock::parts(std::string_view name) const {
  static const std::vector<FigureBlock> none;
  const FigureEntry* entry = find(name);
  return entry ? entry->parts : none;
}

std::vector<ExpressionPtr> FigureDecl::signals() const {
  std::vector<ExpressionPtr> all;
  visit(says, [&](const FigureEntry& entry) {
    if (entry.signal) all.push_back(entry.signal);
  });
  return all;
}

std::vector<ExpressionPtr> FigureDecl::numbers() const {
  std::vector<ExpressionPtr> all;
  visit(says, [&](const FigureEntry& entry) {
    for (const ExpressionPtr& number : entry.numbers)
      if (number) all.push_back(number);
  });
  return all;
}

std::vector<FigureDecl> read_figures(const Node& node, const PlotWords& plots, Report& report) {
  std::vector<FigureDecl> figures;
  if (!node.is_mapping()) {
    report.error(node.mark, "'figures' is a mapping from names to figures, here is {}", describe(node)).named("kind");
    return figures;
  }
  Reader reader(plots, report);
  for (std::size_t i = 0; i < node.items.size(); ++i)
    figures.push_back(reader.figure(node.keys[i], node.key_marks[i], node.items[i]));
  return figures;
}

}  // namespace plantloop
