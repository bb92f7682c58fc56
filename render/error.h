// What rendering throws when the machine lacks something or a picture cannot be made.

#pragma once

#include <stdexcept>

namespace plantloop {

// The text is for the user and says what to do: "OSMesa is not installed: apt install libosmesa6".
struct RenderError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace plantloop
