// Which door to OpenGL is taken.

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>

#include "render/error.h"
#include "render/gl/context.h"

namespace plantloop {
namespace {

constexpr std::array osmesa_libraries{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};

}  // namespace

std::unique_ptr<GlContext> open_osmesa() { return open_osmesa(osmesa_libraries); }

std::unique_ptr<GlContext> open_gl() {
  const char* wanted = std::getenv("PLANTLOOP_GL");
  return open_gl(wanted ? wanted : "");
}

std::unique_ptr<GlContext> open_gl(std::string_view wanted) { return open_gl(wanted, osmesa_libraries); }

std::unique_ptr<GlContext> open_gl(std::string_view wanted, std::span<const char* const> osmesa_names) {
  if (wanted == "osmesa") return open_osmesa(osmesa_names);
  if (wanted == "egl") return open_egl();
  if (!wanted.empty())
    throw RenderError("PLANTLOOP_GL is '" + std::string(wanted) + "'; it may be osmesa or egl, or be left out");
  if (auto context = find_osmesa(osmesa_names)) return context;
  try {
    return open_egl();
  } catch (const RenderError&) {
    throw RenderError("neither OSMesa nor EGL is installed: apt install libosmesa6");
  }
}

}  // namespace plantloop
