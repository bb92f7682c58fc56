// Covariances as text: sums and products of named forms.

#include <fmt/format.h>

#include <cctype>

#include "identify/error.h"
#include "identify/gp/composite.h"
#include "identify/gp/covariance.h"

namespace plantloop::identify {
namespace {

// expression: product { + product }; product: factor { * factor }; factor: name or ( expression ).
class Reader {
 public:
  explicit Reader(const std::string& text) : text_(text) {}

  std::shared_ptr<const Covariance> read() {
    auto result = sum();
    if (skip() != '\0') fail(fmt::format("'{}' is not expected there", text_.substr(at_)));
    return result;
  }

 private:
  using Form = std::shared_ptr<const Covariance>;

  Form sum() {
    std::vector<Form> parts{product()};
    while (take('+')) parts.push_back(product());
    return parts.size() == 1 ? parts[0] : make_sum(std::move(parts));
  }
  Form product() {
    std::vector<Form> parts{factor()};
    while (take('*')) parts.push_back(factor());
    return parts.size() == 1 ? parts[0] : make_product(std::move(parts));
  }
  Form factor() {
    if (take('(')) {
      if (++depth_ > 50) fail("the parentheses are nested more than 50 deep");
      Form inner = sum();
      --depth_;
      if (!take(')')) fail("a ')' is missing");
      return inner;
    }
    skip();
    const std::size_t first = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    const std::string name = text_.substr(first, at_ - first);
    std::string known;
    for (const CovarianceType& type : covariances()) {
      if (type.name == name) return {&type.form(), [](const Covariance*) {}};  // lives as long as the program
      known += (known.empty() ? "" : ", ") + std::string(type.name);
    }
    if (name.empty()) fail(fmt::format("the name of a covariance is missing; there are {}", known));
    fail(fmt::format("there is no covariance '{}'; there are {}", name, known));
  }

  char skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (skip() != c) return false;
    ++at_;
    return true;
  }
  [[noreturn]] void fail(const std::string& why) const { identify::fail("covariance '{}': {}", text_, why); }

  const std::string& text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

std::shared_ptr<const Covariance> find_covariance(const std::string& text) { return Reader(text).read(); }

std::vector<std::string> numbered(std::string_view name, int count) {
  std::vector<std::string> names;
  for (int i = 1; i <= count; ++i) names.push_back(fmt::format("{}{}", name, i));
  return names;
}

}  // namespace plantloop::identify
