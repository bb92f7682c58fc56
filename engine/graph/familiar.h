// What other tools call a block, and what it is here.

#pragma once

#include <string_view>

namespace plantloop {

// Words for "here it is ...", such as "saturation"; empty when the name is no other tool's.
std::string_view familiar_type(std::string_view name);

}  // namespace plantloop
