// What every block type declares: names, units, documentation, defaults.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <variant>

#include "engine/base/text.h"
#include "engine/base/units.h"
#include "engine/block.h"
#include "engine/graph/describe.h"

namespace plantloop {
namespace {

// The keys that FORMAT lists for every instance.
const std::set<std::string_view> keys_of_instances{"type",    "in",     "rate",          "reset",   "enable",
                                                   "trigger", "repeat", "first",         "last",    "doc",
                                                   "unit",    "label",  "zero_crossing", "priority"};

struct Declaration {
  std::string_view name, doc, unit;
};
std::vector<Declaration> declarations(const Block& block) {
  std::vector<Declaration> all;
  for (const Input* d : block.inputs) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const Inputs* d : block.lists) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const Number* d : block.numbers) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const Table* d : block.tables) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const Count* d : block.counts) all.push_back({d->name, d->spec.doc, {}});
  for (const Choice* d : block.choices) all.push_back({d->name, d->doc, {}});
  for (const Text* d : block.texts) all.push_back({d->name, d->spec.doc, {}});
  return all;
}
// States and outputs have names of their own: a state may be called like the output that shows it.
std::vector<Declaration> shown(const Block& block) {
  std::vector<Declaration> all;
  for (const Output* d : block.outputs_declared) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const State* d : block.states) all.push_back({d->name, d->spec.doc, d->spec.unit});
  for (const Discrete* d : block.discretes) all.push_back({d->name, d->spec.doc, d->spec.unit});
  return all;
}

bool has_unit(std::string_view text) { return std::holds_alternative<Unit>(parse_unit(text)); }

// Lower case with underscores, but for the capital letters that books use for matrices and gains.
bool is_good_name(std::string_view name) {
  if (!is_identifier(name)) return false;
  return name.size() == 1 || std::none_of(name.begin(), name.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
}

TEST(EveryBlock, SaysWhatEachOfItsThingsIs) {
  for (const BlockType& type : catalogue()) {
    SCOPED_TRACE(type.name);
    for (const auto& list : {declarations(*type.block), shown(*type.block)}) {
      for (const Declaration& d : list) {
        EXPECT_FALSE(d.doc.empty()) << d.name;
        EXPECT_FALSE(d.doc.ends_with('.')) << d.name << ": " << d.doc;
        EXPECT_TRUE(has_unit(d.unit)) << d.name << " has the unit " << d.unit;
      }
    }
    EXPECT_TRUE(type.summary.ends_with('.')) << type.summary;
    EXPECT_FALSE(type.details.empty());
    EXPECT_FALSE(type.group.empty());
  }
}

TEST(EveryBlock, HasNamesThatAUserCanWrite) {
  for (const BlockType& type : catalogue()) {
    SCOPED_TRACE(type.name);
    EXPECT_TRUE(is_good_name(type.name));
    std::set<std::string_view> names;
    for (const Declaration& d : declarations(*type.block)) {
      EXPECT_TRUE(is_good_name(d.name)) << d.name;
      EXPECT_FALSE(keys_of_instances.contains(d.name)) << d.name;
      EXPECT_TRUE(names.insert(d.name).second) << d.name << " is declared twice";
    }
    std::set<std::string_view> outputs;
    for (const Output* output : type.block->outputs_declared) EXPECT_TRUE(outputs.insert(output->name).second);
    EXPECT_FALSE(outputs.empty());
    for (const Choice* choice : type.block->choices) {
      EXPECT_EQ(std::set<std::string>(choice->words.begin(), choice->words.end()).size(), choice->words.size());
    }
  }
}

TEST(EveryBlock, HasDefaultsInsideItsBounds) {
  for (const BlockType& type : catalogue()) {
    for (const Number* n : type.block->numbers) {
      if (std::isnan(n->spec.init)) continue;
      EXPECT_TRUE(n->spec.init >= n->spec.min && n->spec.init <= n->spec.max &&
                  (n->spec.above == -unbounded || n->spec.init > n->spec.above))
          << type.name << "." << n->name;
    }
    for (const Count* c : type.block->counts) EXPECT_TRUE(c->spec.init >= c->spec.min && c->spec.init <= c->spec.max);
  }
}

TEST(EveryBlock, IsFoundByItsNameInAnOrderedCatalogue) {
  const auto& types = catalogue();
  EXPECT_TRUE(std::is_sorted(types.begin(), types.end(), [](const auto& a, const auto& b) { return a.name < b.name; }));
  for (const BlockType& type : types) EXPECT_EQ(find_block(type.name), &type);
  EXPECT_EQ(find_block("no_such_block"), nullptr);
}

TEST(EveryBlock, StandsInTheListingTheSchemaAndItsDescription) {
  const std::string listing = catalogue_text(), page = catalogue_markdown(), schema = diagram_schema();
  for (const BlockType& type : catalogue()) {
    SCOPED_TRACE(type.name);
    const std::string description = block_text(type), name(type.name);
    EXPECT_THAT(listing, testing::HasSubstr(name));
    EXPECT_THAT(page, testing::HasSubstr(name));
    EXPECT_THAT(schema, testing::HasSubstr("\"" + name + "\""));
    for (const auto& list : {declarations(*type.block), shown(*type.block)}) {
      for (const Declaration& d : list) EXPECT_THAT(description, testing::HasSubstr(std::string(d.name)));
    }
    for (const std::string_view settable : type.block->settable) {
      EXPECT_THAT(schema, testing::HasSubstr("\"" + std::string(settable) + "\""));
    }
  }
}

}  // namespace
}  // namespace plantloop
