// EGL without a surface, loaded at run time: the second door to the same software renderer, for systems without OSMesa.
//
// The few names of EGL's interface (EGL 1.5 and EGL_MESA_platform_surfaceless) stand here, so that its headers are not
// needed.

#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "render/error.h"
#include "render/gl/context.h"

namespace plantloop {
namespace {

using Handle = void*;
using Enum = unsigned int;
using Int = std::int32_t;
using Truth = unsigned int;

constexpr Enum platform_surfaceless = 0x31DD, opengl_api = 0x30A2;
constexpr Int major_version = 0x3098, minor_version = 0x30FB, profile_mask = 0x30FD, core_profile = 1, none = 0x3038;

using GetProcAddress = Handle (*)(const char*);
using GetPlatformDisplay = Handle (*)(Enum, Handle, const Int*);
using Initialize = Truth (*)(Handle, Int*, Int*);
using BindApi = Truth (*)(Enum);
using CreateContext = Handle (*)(Handle, Handle, Handle, const Int*);
using MakeCurrent = Truth (*)(Handle, Handle, Handle, Handle);
using DestroyContext = Truth (*)(Handle, Handle);

class Egl final : public GlContext {
 public:
  explicit Egl(void* library)
      : address_(symbol<GetProcAddress>(library, "eglGetProcAddress")),
        bind_(symbol<BindApi>(library, "eglBindAPI")),
        make_current_(symbol<MakeCurrent>(library, "eglMakeCurrent")),
        destroy_(symbol<DestroyContext>(library, "eglDestroyContext")) {
    // A graphics card would draw other pixels.
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0);
    const auto get_display = reinterpret_cast<GetPlatformDisplay>(address_("eglGetPlatformDisplayEXT"));
    if (!get_display) throw RenderError("EGL is too old: it has no eglGetPlatformDisplayEXT");
    display_ = get_display(platform_surfaceless, nullptr, nullptr);
    if (!display_ || !symbol<Initialize>(library, "eglInitialize")(display_, nullptr, nullptr))
      throw RenderError("EGL does not start without a display: apt install libgl1-mesa-dri");
    const std::array<Int, 7> attributes{major_version, 3, minor_version, 3, profile_mask, core_profile, none};
    if (bind_(opengl_api))
      context_ = symbol<CreateContext>(library, "eglCreateContext")(display_, nullptr, nullptr, attributes.data());
    if (!context_) throw RenderError("EGL gives no OpenGL 3.3 core context: apt install libgl1-mesa-dri");
  }
  ~Egl() override {
    make_current_(display_, nullptr, nullptr, nullptr);
    destroy_(display_, context_);
  }
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;

  void make_current() override {
    if (!bind_(opengl_api) || !make_current_(display_, nullptr, nullptr, context_))
      throw RenderError("EGL does not make its context current");
  }

  void* function(const char* name) override { return address_(name); }

 private:
  template <typename Function>
  static Function symbol(void* library, const char* name) {
    void* found = dlsym(library, name);
    if (!found) throw RenderError(std::string("EGL is too old: it has no ") + name);
    return reinterpret_cast<Function>(found);
  }

  GetProcAddress address_;
  BindApi bind_;
  MakeCurrent make_current_;
  DestroyContext destroy_;
  Handle display_ = nullptr, context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> open_egl() {
  // Never closed, as OSMesa is not.
  if (void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL)) return std::make_unique<Egl>(library);
  throw RenderError("EGL is not installed: apt install libegl1 libgl1-mesa-dri");
}

}  // namespace plantloop
