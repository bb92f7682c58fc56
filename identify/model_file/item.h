// The content of a model file: numbers, texts, lists and mappings that remember where they were written.

#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop::identify {

// One value of a model file. A scalar is kept as text, so that a number comes back with the same bits.
class Item {
 public:
  // An empty mapping, to which set() adds.
  Item() = default;
  static Item list(std::vector<Item> items = {});

  Item(double value);
  Item(std::integral auto value) : Item(scalar_of(whole_text(value))) {}
  Item(std::string_view text);
  Item(const std::string& text) : Item(std::string_view(text)) {}
  Item(const char* text) : Item(std::string_view(text)) {}
  Item(const Eigen::VectorXd& numbers);  // a list
  Item(const Eigen::MatrixXd& rows);     // a list of its rows
  Item(const std::vector<std::string>& texts);

  // Adds a key of a mapping (each once, in the order in which they shall be written), or an item of a list.
  Item& set(std::string key, Item value);
  Item& add(Item value);

  // Reading. What is missing or is something else raises IdentifyError with file, line and key. Sizes of -1 are any.
  bool has(std::string_view key) const;
  const Item& at(std::string_view key) const;
  double number(std::string_view key) const;  // finite, or inf, -inf, nan as written
  long long integer(std::string_view key) const;
  bool flag(std::string_view key) const;
  std::string text(std::string_view key) const;
  std::vector<std::string> texts(std::string_view key) const;
  Eigen::VectorXd vector(std::string_view key, Eigen::Index size = -1) const;
  Eigen::MatrixXd matrix(std::string_view key, Eigen::Index rows = -1, Eigen::Index columns = -1) const;
  const std::vector<Item>& items(std::string_view key) const;  // of a list under the key
  // Refuses keys that are not among these, with the nearest name.
  void only(const std::vector<std::string>& known) const;
  // "models/pump.yaml:12: " with a message; for complaints of the reader's own.
  [[noreturn]] void wrong(std::string_view message) const;

  enum class Kind { mapping, list, scalar };
  Kind kind() const { return kind_; }
  const std::string& scalar() const { return text_; }
  bool is_text() const { return is_text_; }
  const std::vector<std::string>& keys() const { return keys_; }
  const std::vector<Item>& values() const { return values_; }

 private:
  friend class ItemReader;
  static Item scalar_of(std::string text);
  static std::string whole_text(bool value) { return value ? "true" : "false"; }
  static std::string whole_text(std::signed_integral auto value) { return std::to_string(value); }
  static std::string whole_text(std::unsigned_integral auto value) { return std::to_string(value); }
  double to_number(std::string_view what) const;

  Kind kind_ = Kind::mapping;
  bool is_text_ = false;  // of a scalar: written in quotes
  std::string text_, place_;
  std::vector<std::string> keys_;
  std::vector<Item> values_;
};

}  // namespace plantloop::identify
