// The include table. To let a layer know another one, change a line here, and say why in the commit.

#include "tests/house/include_table.h"

#include "tests/house/tree.h"

namespace plantloop::house {

const std::vector<Layer>& layers() {
  static const std::vector<Layer> table{
      {"engine/base", "base", {}},
      {"engine/program", "program", {"engine/base"}},
      {"engine/block", "block", {"engine/base", "engine/program"}},
      {"engine/diagram", "diagram", {"engine/base"}},
      {"engine/graph", "graph", {"engine/base", "engine/program", "engine/block", "engine/diagram"}},
      {"engine/solve", "solve", {"engine/base"}},  // sees a model through an interface of its own
      {"engine/run",
       "run",
       {"engine/base", "engine/program", "engine/block", "engine/diagram", "engine/graph", "engine/solve"}},
      {"engine/analysis",  // questions that need more than a run: explanations, linear models, fits, sweeps
       "analysis",
       {"engine/base", "engine/program", "engine/block", "engine/diagram", "engine/graph", "engine/solve",
        "engine/run"}},
      // Model files are YAML, and there is one reader of YAML.
      {"identify", "identify", {"engine/base", "engine/diagram/document.h"}},
      // What the blocks of learned models share: a block has no header.
      {"learned",
       "learned",
       {"engine/base", "engine/block.h", "engine/block_delay.h", "engine/program/kernel.h",
        "engine/program/status_kernel.h", "identify"}},
      // Predictive control, which searches with models: learned ones, or diagrams.
      {"control",
       "control",
       {"engine/base", "engine/program", "engine/run", "engine/analysis", "engine/graph", "engine/diagram", "learned",
        "identify"}},
      {"blocks",
       "blocks",
       {"engine/base", "engine/block.h", "engine/block_algebra.h", "engine/block_delay.h", "engine/block_design.h",
        "engine/block_fixed_point.h", "engine/block_parts.h", "engine/block_random.h", "engine/program/kernel.h",
        "learned", "control", "identify"}},  // learned models are blocks too
      {"render", "render", {"engine/base"}},
      {"app/figures", "figures", {"engine", "render"}},  // shared by the commands and the Lua host
      {"app/drawing", "drawing", {"engine", "render"}},  // a library, so that tests can look at drawings
      {"scripts/host", "lua_host", {"engine", "identify", "render", "app/figures"}},
      {"app", "", {"engine", "identify", "render", "scripts/host", "app/figures", "app/drawing"}},
      {"bench", "", {"engine", "identify", "learned", "control"}},
      {"tests", "", {"engine", "blocks", "identify", "learned", "control", "render", "scripts/host", "app"}},
  };
  return table;
}

const std::vector<Door>& doors() {
  static const std::vector<Door> table{
      {"fmt/", {"engine", "learned", "control", "blocks", "identify", "render", "scripts", "app", "tests", "bench"}},
      {"yaml-cpp/", {"engine/diagram/document.cpp"}},
      {"cvode/", {"engine/solve/cvode.cpp"}},
      {"ida/", {"engine/solve/ida.cpp"}},
      {"nvector/", {"engine/solve/sundials.h"}},
      {"sundials/", {"engine/solve/sundials.h"}},
      {"sunlinsol/", {"engine/solve/sundials.h"}},
      {"sunmatrix/", {"engine/solve/sundials.h"}},
      {"sunnonlinsol/", {"engine/solve/cvode.cpp"}},
      {"lua", {"scripts/host/stack.h"}},
      {"lauxlib.h", {"scripts/host/stack.h"}},
      {"GL/", {"render/gl"}},
      {"ft2build.h", {"render/text"}},
      {"freetype/", {"render/text"}},
      {"hb", {"render/text"}},
      {"png.h", {"render/backend"}},
      {"zlib.h", {"render/backend"}},
      {"CLI/", {"app"}},
      {"nlohmann/", {"engine/base/report.cpp", "engine/run", "app", "tests"}},
      {"Eigen/",
       {"identify", "learned", "engine/analysis/matrix.cpp", "scripts/host", "render/numbers", "tests", "bench"}},
      {"boost/math/", {"engine/analysis/quantiles.cpp"}},
      {"unsupported/Eigen/FFT", {"identify/spectra/fft.cpp", "render/numbers/statistics.cpp"}},
      {"unsupported/Eigen/MatrixFunctions", {"engine/analysis/matrix.cpp"}},
      {"gtest/", {"tests"}},
      {"gmock/", {"tests"}},
      {"benchmark/", {"bench"}},
      // The operating system.
      {"unistd.h", {"engine/base", "app", "tests", "scripts/host"}},
      {"malloc.h", {"tests"}},
      {"fcntl.h", {"engine/base", "tests", "scripts/host"}},
      {"sys/", {"engine/base", "app", "tests", "scripts/host"}},
      {"dlfcn.h", {"render/gl", "identify/dense", "bench"}},
      {"cxxabi.h", {"tests"}},
      {"malloc.h", {"tests"}},
  };
  return table;
}

const Layer* layer_of(std::string_view path) {
  const Layer* best = nullptr;
  for (const Layer& layer : layers()) {
    if (covers(layer.path, path) && (!best || layer.path.size() > best->path.size())) best = &layer;
  }
  return best;
}

}  // namespace plantloop::house
