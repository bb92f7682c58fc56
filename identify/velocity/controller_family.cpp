// Families of controllers as model files.

#include "identify/velocity/controller_family.h"

#include <fmt/format.h>

#include "identify/model_file/model_file.h"

namespace plantloop::identify {

Item to_item(const ControllerFamily& family) {
  Item points = Item::list();
  for (const ControllerPoint& p : family.points) {
    Item point;
    point.set("at", p.at).set("kp", p.kp).set("ki", p.ki).set("kd", p.kd);
    if (p.K.size() > 0) point.set("K", p.K);
    points.add(point);
  }
  Item item;
  item.set("scheduling", family.scheduling);
  if (!family.states.empty()) item.set("states", family.states);
  item.set("points", points);
  return item;
}

ControllerFamily controller_family_of(const Item& item) {
  if (item.text("type") != "controller_family")
    item.at("type").wrong(fmt::format("a model of type '{}' is no controller_family", item.text("type")));
  item.only({"plantloop_model", "type", "scheduling", "states", "points"});
  ControllerFamily family;
  family.scheduling = item.text("scheduling");
  if (item.has("states")) family.states = item.texts("states");
  const auto n = static_cast<Eigen::Index>(family.states.size());
  for (const Item& one : item.items("points")) {
    one.only({"at", "kp", "ki", "kd", "K"});
    ControllerPoint p;
    p.at = one.number("at");
    if (!family.points.empty() && !(p.at > family.points.back().at))
      one.at("at").wrong("the points ascend by 'at', each stands once");
    const auto gain = [&](const char* key) { return one.has(key) ? one.number(key) : 0.0; };
    p.kp = gain("kp"), p.ki = gain("ki"), p.kd = gain("kd");
    if (n > 0) p.K = one.vector("K", n);
    if (n == 0 && one.has("K")) one.at("K").wrong("'states' must name the states that 'K' belongs to");
    family.points.push_back(std::move(p));
  }
  if (family.points.empty()) item.at("points").wrong("a controller_family has at least one point");
  return family;
}

std::string to_yaml(const ControllerFamily& family) { return to_yaml("controller_family", to_item(family)); }

}  // namespace plantloop::identify
