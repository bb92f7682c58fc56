// plantloop new: a diagram to begin with.

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "app/command.h"
#include "engine/base/files.h"

namespace {

constexpr std::string_view first_diagram = R"(# {name}: a PI controller holds a lag at its set point.
plantloop: 1
title: {name}
parameters:
  kp: {{value: 2, doc: proportional gain}}
  ki: {{value: 3, unit: 1/s, doc: integral gain}}
blocks:
  w: {{type: step, time: 1, after: 1}}
  e: w - y
  u: {{type: pi, in: e, kp: kp, ki: ki}}
  y: {{type: first_order, in: u, tau: 0.5}}
simulation: {{stop: 6}}
record: [w, y, u]
figures:
  response:
    panels:
      - {{y: [w, y], labels: [set point, output], label: y}}
      - {{y: u, label: u}}
expect:
  - {{signal: y, at: 6, value: 1, abs: 1e-2}}
)";

}  // namespace

PLANTLOOP_COMMAND(new) {
  using namespace plantloop;
  using namespace plantloop::app;
  const auto name = std::make_shared<std::string>();
  parser.description("Write a small diagram NAME.yaml that runs, to begin with.");
  parser.add_option("NAME", *name, "name of the diagram, without .yaml")->required();
  parser.footer("Example:\n  plantloop new loop && plantloop run loop.yaml --figures out");
  return [name] {
    std::filesystem::path path(*name);
    if (path.extension() != ".yaml") path += ".yaml";
    if (std::filesystem::exists(path)) {
      complain(fmt::format("'{}' exists already; it was left as it is", path.string()));
      return input_wrong;
    }
    const std::string error =
        write_file(path.string(), fmt::format(fmt::runtime(first_diagram), fmt::arg("name", path.stem().string())));
    if (!error.empty()) {
      complain(fmt::format("cannot write '{}': {}", path.string(), error));
      return input_wrong;
    }
    return write_out(fmt::format("wrote {0}; try: plantloop run {0} --figures out\n", path.string())) ? done
                                                                                                      : run_failed;
  };
}
