// A door to OpenGL: all that drawing knows about the platform.

#pragma once

#include <memory>
#include <span>
#include <string>

namespace plantloop {

// Belongs to the thread that opened it.
struct GlContext {
  virtual ~GlContext() = default;
  virtual void make_current() = 0;
  virtual void* function(const char* name) = 0;
};

// Software rendering off screen by OSMesa, loaded from the first of the library names that exists. Throws RenderError.
std::unique_ptr<GlContext> open_osmesa();
std::unique_ptr<GlContext> open_osmesa(std::span<const char* const> library_names);

}  // namespace plantloop
