// Who may know whom: the layers of the house as data.

#pragma once

#include <string_view>
#include <vector>

namespace plantloop::house {

// A part of the tree, the target that builds it, and what its files may include besides each other. A path stands for
// itself and for all below it; the longest path that covers a file is the file's layer.
struct Layer {
  std::string_view path;
  std::string_view target;  // "" when no library is made of it alone
  std::vector<std::string_view> may_include;
};

// A header of somebody else and the only places that may include it. `header` is the start of the include's text.
struct Door {
  std::string_view header;
  std::vector<std::string_view> files;
};

const std::vector<Layer>& layers();
const std::vector<Door>& doors();

// The layer of a file, or none.
const Layer* layer_of(std::string_view path);

}  // namespace plantloop::house
