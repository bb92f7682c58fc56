// Growing the tree. Out of line: inlined, g++ 12 takes the alternatives that a node does not hold for uninitialised
// ones.

#include "render/scene/scene.h"

namespace plantloop {

Group& Group::group(std::string child_role, std::string child_name) {
  children.push_back({Group{std::move(child_role), std::move(child_name), {}, {}}});
  return std::get<Group>(children.back().item);
}

void Group::add(SceneNode node) { children.push_back(std::move(node)); }

}  // namespace plantloop
