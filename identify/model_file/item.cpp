// The content of a model file: making it, and reading it with complaints that say where.

#include "identify/model_file/item.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "engine/base/numbers.h"
#include "engine/base/report.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

const char* kind_words(const Item& item) {
  if (item.kind() == Item::Kind::mapping) return "a mapping";
  if (item.kind() == Item::Kind::list) return "a list";
  return item.is_text() ? "a text" : "a value";
}

}  // namespace

Item Item::scalar_of(std::string text) {
  Item item;
  item.kind_ = Kind::scalar;
  item.text_ = std::move(text);
  return item;
}

Item Item::list(std::vector<Item> items) {
  Item item;
  item.kind_ = Kind::list;
  item.values_ = std::move(items);
  return item;
}

Item::Item(double value) : Item(scalar_of(shortest(value))) {}

Item::Item(std::string_view text) : kind_(Kind::scalar), is_text_(true), text_(text) {}

Item::Item(const Eigen::VectorXd& numbers) : kind_(Kind::list) {
  for (const double v : numbers) values_.emplace_back(v);
}

Item::Item(const Eigen::MatrixXd& rows) : kind_(Kind::list) {
  for (Index i = 0; i < rows.rows(); ++i) values_.emplace_back(Eigen::VectorXd(rows.row(i).transpose()));
}

Item::Item(const std::vector<std::string>& texts) : kind_(Kind::list) {
  for (const std::string& t : texts) values_.emplace_back(t);
}

Item& Item::set(std::string key, Item value) {
  assert(kind_ == Kind::mapping && !has(key));
  keys_.push_back(std::move(key));
  values_.push_back(std::move(value));
  return *this;
}

Item& Item::add(Item value) {
  assert(kind_ == Kind::list);
  values_.push_back(std::move(value));
  return *this;
}

void Item::wrong(std::string_view message) const { fail("{}{}{}", place_, place_.empty() ? "" : ": ", message); }

bool Item::has(std::string_view key) const { return std::find(keys_.begin(), keys_.end(), key) != keys_.end(); }

const Item& Item::at(std::string_view key) const {
  if (kind_ != Kind::mapping) wrong(fmt::format("a mapping with '{}' is expected, here is {}", key, kind_words(*this)));
  const auto found = std::find(keys_.begin(), keys_.end(), key);
  if (found == keys_.end()) wrong(fmt::format("the key '{}' is missing; there are: {}", key, fmt::join(keys_, ", ")));
  return values_[static_cast<std::size_t>(found - keys_.begin())];
}

double Item::to_number(std::string_view what) const {
  if (kind_ == Kind::scalar && !is_text_) {
    if (text_ == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (const auto value = parse_number(text_)) return *value;
  }
  wrong(fmt::format("'{}' must be a number, it is {}", what,
                    kind_ == Kind::scalar ? fmt::format("'{}'", text_) : std::string(kind_words(*this))));
}

double Item::number(std::string_view key) const { return at(key).to_number(key); }

long long Item::integer(std::string_view key) const {
  const Item& item = at(key);
  const auto value = item.kind_ == Kind::scalar && !item.is_text_ ? parse_integer(item.text_) : std::nullopt;
  if (!value) item.wrong(fmt::format("'{}' must be a whole number", key));
  return *value;
}

bool Item::flag(std::string_view key) const {
  const Item& item = at(key);
  if (item.kind_ == Kind::scalar && !item.is_text_ && (item.text_ == "true" || item.text_ == "false")) {
    return item.text_ == "true";
  }
  item.wrong(fmt::format("'{}' must be true or false", key));
}

std::string Item::text(std::string_view key) const {
  const Item& item = at(key);
  if (item.kind_ != Kind::scalar) item.wrong(fmt::format("'{}' must be a text, it is {}", key, kind_words(item)));
  return item.text_;
}

const std::vector<Item>& Item::items(std::string_view key) const {
  const Item& item = at(key);
  if (item.kind_ != Kind::list) item.wrong(fmt::format("'{}' must be a list, it is {}", key, kind_words(item)));
  return item.values_;
}

std::vector<std::string> Item::texts(std::string_view key) const {
  std::vector<std::string> result;
  for (const Item& item : items(key)) {
    if (item.kind_ != Kind::scalar) item.wrong(fmt::format("'{}' must be a list of texts", key));
    result.push_back(item.text_);
  }
  return result;
}

Eigen::VectorXd Item::vector(std::string_view key, Index size) const {
  const std::vector<Item>& list = items(key);
  const auto count = static_cast<Index>(list.size());
  if (size >= 0 && count != size) at(key).wrong(fmt::format("'{}' must be {} numbers, it has {}", key, size, count));
  Eigen::VectorXd result(count);
  for (Index i = 0; i < count; ++i) result[i] = list[static_cast<std::size_t>(i)].to_number(key);
  return result;
}

Eigen::MatrixXd Item::matrix(std::string_view key, Index rows, Index columns) const {
  const std::vector<Item>& list = items(key);
  const auto count = static_cast<Index>(list.size());
  if (rows >= 0 && count != rows) at(key).wrong(fmt::format("'{}' must have {} rows, it has {}", key, rows, count));
  Index width = columns;
  if (width < 0) width = list.empty() ? 0 : static_cast<Index>(list[0].values_.size());
  Eigen::MatrixXd result(count, width);
  for (Index i = 0; i < count; ++i) {
    const Item& row = list[static_cast<std::size_t>(i)];
    if (row.kind_ != Kind::list || static_cast<Index>(row.values_.size()) != width) {
      row.wrong(fmt::format("a row of '{}' must be a list of {} numbers", key, width));
    }
    for (Index j = 0; j < width; ++j) result(i, j) = row.values_[static_cast<std::size_t>(j)].to_number(key);
  }
  return result;
}

void Item::only(const std::vector<std::string>& known) const {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (std::find(known.begin(), known.end(), keys_[i]) != known.end()) continue;
    const std::string near = nearest(keys_[i], known);
    values_[i].wrong(fmt::format("there is no key '{}' here{}; there are: {}", keys_[i],
                                 near.empty() ? "" : fmt::format(", did you mean '{}'", near), fmt::join(known, ", ")));
  }
}

}  // namespace plantloop::identify
