// A door to OpenGL: all that drawing knows about the platform.

#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

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
// The same, or null when there is no library of these names.
std::unique_ptr<GlContext> find_osmesa(std::span<const char* const> library_names);

// The same renderer by EGL without a surface. Throws RenderError.
std::unique_ptr<GlContext> open_egl();

// OSMesa, or EGL where it is missing. `wanted`: osmesa or egl; empty: any. Without an argument the environment variable
// PLANTLOOP_GL says what is wanted. Throws RenderError.
std::unique_ptr<GlContext> open_gl();
std::unique_ptr<GlContext> open_gl(std::string_view wanted);
std::unique_ptr<GlContext> open_gl(std::string_view wanted, std::span<const char* const> osmesa_names);

}  // namespace plantloop
