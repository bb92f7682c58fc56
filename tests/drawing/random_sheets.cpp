// Every input is fed by a random output; what is not read becomes a result or stays open.

#include "tests/drawing/random_sheets.h"

#include <map>
#include <random>
#include <string>

namespace plantloop {

Sheet random_sheet(std::uint32_t seed, int blocks) {
  std::minstd_rand random(seed * 7919 + 17);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  Sheet sheet;
  sheet.title = "seed " + std::to_string(seed);
  for (int i = 0; i < blocks; ++i) {
    SheetBlock b;
    b.path = "b" + std::to_string(100 + i);
    const int kind = below(10);
    if (kind < 2 || i == 0) {
      b.caption = "source";
    } else if (kind < 5) {
      b.shape = SheetBlock::Shape::circle;
      const int terms = 2 + below(4);
      for (int k = 0; k < terms; ++k) b.inputs.emplace_back(below(3) == 0 ? "−" : "+");
    } else if (kind < 6) {
      b.shape = SheetBlock::Shape::gain;
      b.formula = "K";
      b.inputs = {""};
    } else {
      const int count = 1 + below(3);
      for (int k = 0; k < count; ++k) b.inputs.push_back("u_" + std::to_string(k + 1));
      b.formula = Formula(Formula::Kind::fraction, {"1", "s + 1"});
      b.caption = "block " + std::to_string(i);
      b.has_state = below(2) == 0;
    }
    const int outputs = b.shape == SheetBlock::Shape::box ? 1 + below(5) / 4 : 1;
    for (int k = 0; k < outputs; ++k) b.outputs.push_back("y_" + std::to_string(k + 1));
    sheet.blocks.push_back(std::move(b));
  }
  std::map<std::pair<int, int>, SheetWire> wires;
  for (int i = 0; i < blocks; ++i) {
    const int inputs = static_cast<int>(sheet.blocks[static_cast<std::size_t>(i)].inputs.size());
    for (int port = 0; port < inputs; ++port) {
      // Mostly from the neighbourhood, so that there are chains.
      const int from = below(3) == 0 ? below(blocks) : std::max(0, i - 1 - below(3));
      const int out = below(static_cast<int>(sheet.blocks[static_cast<std::size_t>(from)].outputs.size()));
      SheetWire& wire = wires[{from, out}];
      wire.from = {from, out};
      wire.to.push_back({i, port});
      wire.is_shown = wire.is_shown || below(6) == 0;
      if (below(4) == 0) wire.label = wire.result = "x_" + std::to_string(from);
    }
  }
  for (auto& [key, wire] : wires) sheet.wires.push_back(std::move(wire));
  return sheet;
}

}  // namespace plantloop
