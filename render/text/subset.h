// The part of a font that a document needs, as a font program to embed.

#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace plantloop {

struct SubsetFont {
  std::string program;  // a TrueType file, or the bare CFF table of an OpenType one
  bool is_cff = false;
  std::map<std::uint32_t, std::uint32_t> glyphs;  // of the font -> of the program
  std::vector<double> advances;                   // of the program's glyphs; in thousandths of the em, as all measures
  double ascent = 0, descent = 0, cap_height = 0;
  std::array<double, 4> box{};  // left, bottom, right, top of all glyphs
};

// Throws RenderError when HarfBuzz cannot cut the font.
SubsetFont subset(int font, const std::set<std::uint32_t>& glyphs);

}  // namespace plantloop
