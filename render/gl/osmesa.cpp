// OSMesa, loaded at run time: a program that draws nothing pays nothing, and no other GL library can get in the way.

#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>

#include "render/error.h"
#include "render/gl/context.h"

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the names are the leak checker's.
// Asked for by the leak checker of a sanitized build: Mesa and LLVM keep memory until the process ends.
extern "C" __attribute__((weak)) const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() { return "leak:libOSMesa\nleak:libLLVM\n"; }
// Without a word about it on standard error.
extern "C" __attribute__((weak)) const char* __lsan_default_options();
const char* __lsan_default_options() { return "print_suppressions=0"; }
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace plantloop {
namespace {

using CreateContext = OSMesaContext(GLAPIENTRY*)(const int*, OSMesaContext);
using MakeCurrent = GLboolean(GLAPIENTRY*)(OSMesaContext, void*, GLenum, GLsizei, GLsizei);
using DestroyContext = void(GLAPIENTRY*)(OSMesaContext);
using GetProcAddress = OSMESAproc(GLAPIENTRY*)(const char*);

class OsMesa final : public GlContext {
 public:
  explicit OsMesa(void* library)
      : make_current_(symbol<MakeCurrent>(library, "OSMesaMakeCurrent")),
        destroy_(symbol<DestroyContext>(library, "OSMesaDestroyContext")),
        address_(symbol<GetProcAddress>(library, "OSMesaGetProcAddress")) {
    const std::array attributes{OSMESA_FORMAT,
                                OSMESA_RGBA,
                                OSMESA_DEPTH_BITS,
                                0,
                                OSMESA_STENCIL_BITS,
                                0,
                                OSMESA_ACCUM_BITS,
                                0,
                                OSMESA_PROFILE,
                                OSMESA_CORE_PROFILE,
                                OSMESA_CONTEXT_MAJOR_VERSION,
                                3,
                                OSMESA_CONTEXT_MINOR_VERSION,
                                3,
                                0};
    context_ = symbol<CreateContext>(library, "OSMesaCreateContextAttribs")(attributes.data(), nullptr);
    if (!context_) throw RenderError("OSMesa gives no OpenGL 3.3 core context");
  }
  ~OsMesa() override {
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }
  OsMesa(const OsMesa&) = delete;
  OsMesa& operator=(const OsMesa&) = delete;

  // The buffer is a formality: everything is drawn into a framebuffer object.
  void make_current() override {
    if (!make_current_(context_, buffer_.data(), GL_UNSIGNED_BYTE, side, side))
      throw RenderError("OSMesa does not make its context current");
  }

  void* function(const char* name) override { return reinterpret_cast<void*>(address_(name)); }

 private:
  template <typename Function>
  static Function symbol(void* library, const char* name) {
    void* found = dlsym(library, name);
    if (!found) throw RenderError(std::string("OSMesa is too old: it has no ") + name);
    return reinterpret_cast<Function>(found);
  }

  static constexpr int side = 16;
  std::array<unsigned char, side * side * 4> buffer_{};
  MakeCurrent make_current_;
  DestroyContext destroy_;
  GetProcAddress address_;
  OSMesaContext context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> find_osmesa(std::span<const char* const> library_names) {
  // Never closed: Mesa's and LLVM's own exit handlers would be gone when they are called.
  for (const char* name : library_names)
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return std::make_unique<OsMesa>(library);
  return nullptr;
}

std::unique_ptr<GlContext> open_osmesa(std::span<const char* const> library_names) {
  if (auto context = find_osmesa(library_names)) return context;
  throw RenderError("OSMesa is not installed: apt install libosmesa6");
}

}  // namespace plantloop
