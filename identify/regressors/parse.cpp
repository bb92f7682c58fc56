// Regressors as text: reading and writing.

#include <algorithm>
#include <cctype>
#include <map>

#include "engine/base/numbers.h"
#include "engine/base/report.h"
#include "engine/base/text.h"
#include "identify/error.h"
#include "identify/regressors/regressors.h"

namespace plantloop::identify {
namespace {

constexpr int longest = 100'000;
constexpr std::size_t most = 100'000;

// Equal signals and lags become one factor with the sum of the powers.
Regressor product(const Regressor& a, const Regressor& b) {
  Regressor result = a;
  for (const Factor& f : b.factors) {
    const auto same = std::find_if(result.factors.begin(), result.factors.end(), [&](const Factor& g) {
      return g.of_output == f.of_output && g.channel == f.channel && g.lag == f.lag;
    });
    if (same != result.factors.end()) {
      same->power += f.power;
    } else {
      result.factors.push_back(f);
    }
  }
  // Outputs first, as the book orders them.
  std::sort(result.factors.begin(), result.factors.end(), [](const Factor& x, const Factor& y) {
    if (x.of_output != y.of_output) return x.of_output;
    return x < y;
  });
  return result;
}

class Parser {
 public:
  Parser(std::string_view text, RegressorSet& set) : text_(text), set_(set) {}

  void read() {
    skip();
    if (at_ == text_.size()) fail("there are no regressors; write, for example, 'y(k-1), u(k-1..2)'");
    while (true) {
      skip();
      const std::size_t begin = at_;
      for (Regressor& r : term()) add(std::move(r), begin);
      skip();
      if (at_ == text_.size()) return;
      expect(',', "a comma between regressors");
    }
  }

 private:
  [[noreturn]] void stop(std::size_t at, const std::string& why) const {
    fail("regressors, character {}: {}\n  {}\n  {}^", at + 1, why, text_, std::string(at, ' '));
  }

  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  std::string found() const {
    return at_ < text_.size() ? fmt::format("'{}'", printable(text_.substr(at_, character_length(text_, at_))))
                              : std::string("the end");
  }
  void expect(char c, const char* what) {
    if (!take(c)) stop(at_, fmt::format("{} is expected, here is {}", what, found()));
  }

  int integer(const char* what) {
    skip();
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    const std::optional<long> value = parse_integer(text_.substr(begin, at_ - begin));
    if (!value) stop(begin, fmt::format("{} is expected, here is {}", what, found()));
    if (*value > longest) stop(begin, fmt::format("{} is at most {}", what, longest));
    return static_cast<int>(*value);
  }

  std::vector<Regressor> term() {
    std::vector<Regressor> products = factor();
    while (take('*')) {
      const std::vector<Regressor> next = factor();
      std::vector<Regressor> all;
      if (products.size() * next.size() > most) stop(at_, "these ranges make too many products");
      for (const Regressor& a : products) {
        for (const Regressor& b : next) all.push_back(product(a, b));
      }
      products = std::move(all);
    }
    return products;
  }

  std::vector<Regressor> factor() {
    skip();
    const std::size_t begin = at_;
    if (take('1')) return {Regressor{}};
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    if (at_ == begin) stop(begin, fmt::format("a signal as in y(k-1) is expected, here is {}", found()));
    Factor base = signal(std::string(text_.substr(begin, at_ - begin)), begin);
    expect('(', "'(' as in y(k-1)");
    if (!take('k')) stop(at_, fmt::format("'k' as in y(k-1) is expected, here is {}", found()));
    skip();
    int from = 0;
    int to = 0;
    const std::size_t lag_at = at_;
    if (take('+')) stop(lag_at, "a regressor is of the past: k-1, not k+1");
    if (take('-')) {
      from = to = integer("a whole number of samples");
    }
    if (take('.')) {
      expect('.', "'..' as in u(k-1..4)");
      to = integer("the last lag of the range");
      if (to < from) stop(lag_at, fmt::format("the range begins at {} and ends at {}", from, to));
    }
    if (base.of_output && from == 0) stop(lag_at, "an output is a regressor from k-1 on; at k it is what is predicted");
    if (set_.is_error(base) && from == 0)
      stop(lag_at, "a prediction error is a regressor from k-1 on; at k it is not known");
    expect(')', "')'");
    if (take('^')) {
      base.power = integer("a power from 1");
      if (base.power < 1 || base.power > 100) stop(at_, "a power lies between 1 and 100");
    }
    std::vector<Regressor> list;
    for (base.lag = from; base.lag <= to; ++base.lag) list.push_back({{base}});
    return list;
  }

  // Of `u` where there is one, of `u2` where there are two or more; 0: the name is none.
  static long number_of(const std::string& name, char letter, long count) {
    if (name[0] != letter) return 0;
    if (name.size() == 1) return count == 1 ? 1 : 0;
    const std::optional<long> number = parse_integer(std::string_view(name).substr(1));
    return number && *number >= 1 && *number <= count ? *number : 0;
  }

  void add_errors(std::size_t at) {
    if (set_.errors > 0) return;
    for (std::size_t i = 0; i < set_.outputs.size(); ++i) {
      std::string name = set_.outputs.size() == 1 ? "e" : fmt::format("e{}", i + 1);
      for (const std::vector<std::string>* taken : {&set_.inputs, &set_.outputs}) {
        if (std::find(taken->begin(), taken->end(), name) != taken->end())
          stop(at, fmt::format("a signal of the data is named '{}', so it cannot be a prediction error", name));
      }
      set_.inputs.push_back(std::move(name));
    }
    set_.errors = static_cast<int>(set_.outputs.size());
  }

  Factor signal(const std::string& name, std::size_t at) {
    for (const bool of_output : {true, false}) {
      const std::vector<std::string>& names = of_output ? set_.outputs : set_.inputs;
      const auto named = std::find(names.begin(), names.end(), name);
      if (named != names.end()) return {of_output, static_cast<int>(named - names.begin()), 0, 1};
    }
    for (const bool of_output : {true, false}) {
      const auto count = of_output ? static_cast<long>(set_.outputs.size()) : set_.data_inputs();
      const long number = number_of(name, of_output ? 'y' : 'u', count);
      if (number > 0) return {of_output, static_cast<int>(number - 1), 0, 1};
    }
    const long error = number_of(name, 'e', static_cast<long>(set_.outputs.size()));
    if (error > 0) {
      add_errors(at);
      return {false, set_.data_inputs() + static_cast<int>(error - 1), 0, 1};
    }
    std::vector<std::string> known = set_.outputs;
    known.insert(known.end(), set_.inputs.begin(), set_.inputs.end());
    const std::string near = nearest(name, known);
    stop(at, fmt::format("there is no signal '{}'{}; there are: {}", name,
                         near.empty() ? "" : fmt::format(", did you mean '{}'", near), fmt::join(known, ", ")));
  }

  void add(Regressor r, std::size_t at) {
    if (set_.list.size() >= most) stop(at, fmt::format("there are more than {} regressors", most));
    std::string key = to_text(r, set_);
    if (!seen_.emplace(key, 0).second) stop(at, fmt::format("{} is there twice", key));
    set_.list.push_back(std::move(r));
  }

  std::string_view text_;
  RegressorSet& set_;
  std::map<std::string, int> seen_;
  std::size_t at_ = 0;
};

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& c : channels) names.push_back(c.name);
  return names;
}

// A name that the grammar can read back: the signal's own, or its number where that is no identifier.
std::string written(const Factor& f, const RegressorSet& set) {
  const std::string& name = (f.of_output ? set.outputs : set.inputs)[static_cast<std::size_t>(f.channel)];
  return is_identifier(name) ? name : fmt::format("{}{}", f.of_output ? 'y' : 'u', f.channel + 1);
}

void extend(const RegressorSet& set, std::size_t from, int degree, const Regressor& so_far,
            std::vector<Regressor>& out) {
  if (degree == 0) {
    out.push_back(so_far);
    if (out.size() > most) fail("this polynomial has more than {} terms; take a lower degree or fewer lags", most);
    return;
  }
  for (std::size_t i = from; i < set.list.size(); ++i) extend(set, i, degree - 1, product(so_far, set.list[i]), out);
}

}  // namespace

RegressorSet parse_regressors(std::string_view text, std::vector<std::string> inputs,
                              std::vector<std::string> outputs) {
  RegressorSet set{std::move(inputs), std::move(outputs), {}, 0};
  Parser(text, set).read();
  return set;
}

RegressorSet parse_regressors(std::string_view text, const DataSet& data) {
  return parse_regressors(text, names_of(data.inputs), names_of(data.outputs));
}

std::string to_text(const Regressor& regressor, const RegressorSet& set) {
  if (regressor.factors.empty()) return "1";
  std::string text;
  for (const Factor& f : regressor.factors) {
    if (!text.empty()) text += '*';
    text += f.lag == 0 ? fmt::format("{}(k)", written(f, set)) : fmt::format("{}(k-{})", written(f, set), f.lag);
    if (f.power > 1) text += fmt::format("^{}", f.power);
  }
  return text;
}

std::string to_text(const RegressorSet& set) {
  std::string text;
  for (const Regressor& r : set.list) text += (text.empty() ? "" : ", ") + to_text(r, set);
  return text;
}

RegressorSet polynomial(const RegressorSet& set, int degree, bool constant) {
  if (degree < 1 || degree > 20) fail("the degree of a polynomial lies between 1 and 20, it is {}", degree);
  for (const Regressor& r : set.list) {
    if (r.factors.size() != 1 || r.degree() != 1) {
      fail("a polynomial is made of single signals, as in 'y(k-1), u(k-1)', not of {}", to_text(r, set));
    }
  }
  RegressorSet result{set.inputs, set.outputs, {}, set.errors};
  if (constant) result.list.emplace_back();
  for (int d = 1; d <= degree; ++d) extend(set, 0, d, {}, result.list);
  return result;
}

}  // namespace plantloop::identify
