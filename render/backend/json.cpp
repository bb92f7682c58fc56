// The scene itself as canonical JSON: what a picture shows, as text that can be compared.

#include "render/backend/backend.h"
#include "render/scene/dump.h"

namespace plantloop {
namespace {

std::vector<std::uint8_t> json_bytes(const Scene& scene) {
  const std::string text = to_json(scene);
  return {text.begin(), text.end()};
}

}  // namespace

extern const Backend backend_json;
const Backend backend_json{"json", json_bytes};

}  // namespace plantloop
