// Velocity-form families as model files.

#include "identify/velocity/velocity_family.h"

#include <fmt/format.h>

#include "identify/model_file/model_file.h"

namespace plantloop::identify {

using Eigen::Index;

namespace {

Item channel_items(const std::vector<Channel>& channels) {
  Item list = Item::list();
  for (const Channel& channel : channels) {
    Item item;
    item.set("name", channel.name);
    if (!channel.unit.empty()) item.set("unit", channel.unit);
    list.add(item);
  }
  return list;
}

std::vector<Channel> channels_in(const Item& item, std::string_view key) {
  std::vector<Channel> channels;
  for (const Item& one : item.items(key)) {
    one.only({"name", "unit"});
    channels.push_back({one.text("name"), one.has("unit") ? one.text("unit") : ""});
  }
  return channels;
}

}  // namespace

Item to_item(const VelocityFamily& family) {
  Item points = Item::list();
  for (const VelocityPoint& p : family.points) {
    Item point;
    point.set("at", p.at).set("A", p.A).set("B", p.B).set("C", p.C).set("D", p.D);
    point.set("x", p.x).set("u", p.u).set("y", p.y);
    points.add(point);
  }
  Item item;
  if (family.Ts > 0) item.set("Ts", family.Ts);
  item.set("scheduling", family.scheduling)
      .set("states", family.states)
      .set("inputs", channel_items(family.inputs))
      .set("outputs", channel_items(family.outputs))
      .set("points", points);
  return item;
}

VelocityFamily velocity_family_of(const Item& item) {
  if (item.text("type") != "velocity_family")
    item.at("type").wrong(fmt::format("a model of type '{}' is no velocity_family", item.text("type")));
  item.only({"plantloop_model", "type", "Ts", "scheduling", "states", "inputs", "outputs", "points"});
  VelocityFamily family;
  if (item.has("Ts")) {
    family.Ts = item.number("Ts");
    if (!(family.Ts > 0)) item.at("Ts").wrong("the sampling time 'Ts' must be greater than 0 s");
  }
  family.scheduling = item.text("scheduling");
  family.states = item.texts("states");
  family.inputs = channels_in(item, "inputs");
  family.outputs = channels_in(item, "outputs");
  const auto n = static_cast<Index>(family.states.size()), m = static_cast<Index>(family.inputs.size()),
             outputs = static_cast<Index>(family.outputs.size());
  if (n == 0 || m == 0 || outputs == 0) item.wrong("a velocity_family has states, inputs and outputs");
  for (const Item& one : item.items("points")) {
    one.only({"at", "A", "B", "C", "D", "x", "u", "y"});
    VelocityPoint p;
    p.at = one.number("at");
    if (!family.points.empty() && !(p.at > family.points.back().at))
      one.at("at").wrong("the points ascend by 'at', each stands once");
    p.A = one.matrix("A", n, n);
    p.B = one.matrix("B", n, m);
    p.C = one.matrix("C", outputs, n);
    p.D = one.matrix("D", outputs, m);
    p.x = one.vector("x", n);
    p.u = one.vector("u", m);
    p.y = one.vector("y", outputs);
    family.points.push_back(std::move(p));
  }
  if (family.points.empty()) item.at("points").wrong("a velocity_family has at least one point");
  return family;
}

std::string to_yaml(const VelocityFamily& family) { return to_yaml("velocity_family", to_item(family)); }

}  // namespace plantloop::identify
