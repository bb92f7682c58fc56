// The small markup of labels (render/figure.h), as a tree.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

struct Piece {
  enum class Kind {
    text,
    fraction,  // parts: above, below
    root,      // parts: what stands under it
    accent,    // parts: what it stands over; text: the accent's combining character
  };
  Kind kind = Kind::text;
  int level = 0;  // 0 on the base line, 1 above, -1 below
  std::u32string text;
  std::vector<std::vector<Piece>> parts;
};

// Never fails: what is no markup stands for itself.
std::vector<Piece> parse_markup(std::u32string_view text);

// As a reader would say it, with sub- and superscripts in Unicode where they exist: "x₁", "ŷ", "(a+1)/b", "√2".
std::u32string readable(const std::vector<Piece>& pieces);

}  // namespace plantloop
