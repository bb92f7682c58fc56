// Fills the table of OpenGL functions.

#include "render/gl/functions.h"

#include <string>

#include "render/error.h"

namespace plantloop {

GlFunctions load_functions(GlContext& context) {
  GlFunctions gl;
#define PLANTLOOP_GL_LOAD(type, name)                             \
  gl.name = reinterpret_cast<type>(context.function("gl" #name)); \
  if (!gl.name) throw RenderError("OpenGL has no function gl" #name);
  PLANTLOOP_GL_FUNCTIONS(PLANTLOOP_GL_LOAD)
#undef PLANTLOOP_GL_LOAD
  return gl;
}

}  // namespace plantloop
