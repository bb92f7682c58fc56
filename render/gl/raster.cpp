// Pixels by OpenGL: sixteen samples to the pixel on a plain grid, whole-number averaging on the CPU.
//
// Nothing is left to the driver in which drivers differ: one colour to the batch, no interpolation, no lines or points
// of GL's own, corners on a grid that the rasteriser keeps exactly. The picture is drawn in strips: the viewport keeps
// its full size and moves over a small framebuffer, so that strips and one piece give the same bits.

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "render/error.h"
#include "render/geometry/triangles.h"
#include "render/gl/functions.h"
#include "render/image.h"

namespace plantloop {
namespace {

constexpr int strip_rows = 64;       // pixels
constexpr int largest_side = 16384;  // samples: the limit of viewports

const char* const vertex_source =
    "#version 330 core\n"
    "uniform vec4 map;\n"
    "layout(location = 0) in vec2 corner;\n"
    "void main() { gl_Position = vec4(corner * map.xy + map.zw, 0.0, 1.0); }\n";
const char* const fragment_source =
    "#version 330 core\n"
    "uniform vec4 color;\n"
    "out vec4 result;\n"
    "void main() { result = color; }\n";

int floor_div(std::int64_t a, std::int64_t b) { return static_cast<int>(a >= 0 ? a / b : -((-a + b - 1) / b)); }

class Raster {
 public:
  Raster() : context_(open_gl()) {
    context_->make_current();
    gl_ = load_functions(*context_);
    const GLuint program = gl_.CreateProgram();
    attach(program, GL_VERTEX_SHADER, vertex_source);
    attach(program, GL_FRAGMENT_SHADER, fragment_source);
    gl_.LinkProgram(program);
    GLint linked = 0;
    gl_.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) throw RenderError("OpenGL does not link the program that draws figures");
    gl_.UseProgram(program);
    map_ = gl_.GetUniformLocation(program, "map");
    color_ = gl_.GetUniformLocation(program, "color");
    GLuint name = 0;
    gl_.GenVertexArrays(1, &name);
    gl_.BindVertexArray(name);
    gl_.GenBuffers(1, &name);
    gl_.BindBuffer(GL_ARRAY_BUFFER, name);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl_.GenFramebuffers(1, &frame_);
    gl_.GenRenderbuffers(1, &pixels_);
    gl_.GenRenderbuffers(1, &stencil_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, frame_);
    gl_.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.Enable(GL_SCISSOR_TEST);
  }

  std::string renderer() const {
    const auto* name = gl_.GetString(GL_RENDERER);
    return name ? reinterpret_cast<const char*>(name) : "";
  }

  Image draw(const Scene& scene) {
    context_->make_current();
    samples_ = 4;
    while (samples_ > 1 && samples_ * std::max(scene.width, scene.height) > largest_side) samples_ /= 2;
    width_ = scene.width;
    height_ = scene.height;
    resize(width_ * samples_, strip_rows * samples_);
    upload(triangulate(scene));
    const auto w = static_cast<float>(width_), h = static_cast<float>(height_);
    gl_.Uniform4f(map_, 2.0f / (256.0f * w), 2.0f / (256.0f * h), -1.0f, -1.0f);

    Image image{width_, height_,
                std::vector<std::uint8_t>(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3)};
    read_.resize(static_cast<std::size_t>(width_ * samples_) * static_cast<std::size_t>(strip_rows * samples_) * 4);
    for (int top = 0; top < height_; top += strip_rows) {
      const int rows = std::min(strip_rows, height_ - top);
      strip(scene.background, top, rows);
      // In the order in which the driver keeps them: any other costs a pass over all samples.
      gl_.ReadPixels(0, 0, width_ * samples_, rows * samples_, GL_BGRA, GL_UNSIGNED_BYTE, read_.data());
      average(image, top, rows);
    }
    if (gl_.GetError() != GL_NO_ERROR) throw RenderError("OpenGL reports an error while drawing a figure");
    return image;
  }

 private:
  std::unique_ptr<GlContext> context_;
  GlFunctions gl_;
  GLint map_ = 0, color_ = 0;
  GLuint frame_ = 0, pixels_ = 0, stencil_ = 0;
  int frame_width_ = 0, frame_height_ = 0;
  int width_ = 0, height_ = 0, samples_ = 4;
  std::vector<Batch> batches_;
  std::vector<std::int32_t> covers_;  // where each batch's covering boxes begin
  std::vector<std::uint8_t> read_;
  std::vector<std::uint16_t> sums_;
  std::vector<GLint> firsts_;
  std::vector<GLsizei> counts_;

  void attach(GLuint program, GLenum kind, const char* source) const {
    const GLuint shader = gl_.CreateShader(kind);
    gl_.ShaderSource(shader, 1, &source, nullptr);
    gl_.CompileShader(shader);
    gl_.AttachShader(program, shader);
    gl_.DeleteShader(shader);
  }

  void resize(int width, int height) {
    if (width == frame_width_ && height == frame_height_) return;
    gl_.BindRenderbuffer(GL_RENDERBUFFER, pixels_);
    gl_.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, pixels_);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, stencil_);
    gl_.RenderbufferStorage(GL_RENDERBUFFER, GL_STENCIL_INDEX8, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_STENCIL_ATTACHMENT, GL_RENDERBUFFER, stencil_);
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw RenderError("OpenGL gives no framebuffer of the figure's size");
    frame_width_ = width;
    frame_height_ = height;
  }

  void upload(Triangles triangles) {
    std::vector<float> data;
    data.reserve(2 * triangles.corners.size());
    const auto put = [&](Fixed x, Fixed y) {
      data.push_back(static_cast<float>(x));
      data.push_back(static_cast<float>(y));
    };
    for (const Point p : triangles.corners) put(p.x, p.y);
    batches_ = std::move(triangles.batches);
    covers_.clear();
    for (const Batch& batch : batches_) {
      covers_.push_back(static_cast<std::int32_t>(data.size() / 2));
      for (const Rect& b : batch.covers)
        for (const Point p : {Point{b.left, b.top},
                              {b.right, b.top},
                              {b.right, b.bottom},
                              {b.left, b.top},
                              {b.right, b.bottom},
                              {b.left, b.bottom}})
          put(p.x, p.y);
    }
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(float)), data.data(), GL_STREAM_DRAW);
  }

  void strip(Color background, int top, int rows) {
    const int offset = top * samples_;
    gl_.Viewport(0, -offset, width_ * samples_, height_ * samples_);
    gl_.Scissor(0, 0, width_ * samples_, rows * samples_);
    gl_.ClearColor(static_cast<float>(background.r) / 255.0f, static_cast<float>(background.g) / 255.0f,
                   static_cast<float>(background.b) / 255.0f, 1.0f);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    const Fixed strip_top = top * 256, strip_bottom = (top + rows) * 256;
    for (std::size_t i = 0; i < batches_.size(); ++i) {
      const Batch& batch = batches_[i];
      if (!set_scissor(batch.clip, offset, rows)) continue;
      select(batch, strip_top, strip_bottom);
      const auto parts = static_cast<GLsizei>(firsts_.size());
      if (parts == 0) continue;
      const Color c = batch.color;
      gl_.Uniform4f(color_, static_cast<float>(c.r) / 255.0f, static_cast<float>(c.g) / 255.0f,
                    static_cast<float>(c.b) / 255.0f, static_cast<float>(c.a) / 255.0f);
      if (batch.kind == Batch::Kind::direct) {
        gl_.MultiDrawArrays(GL_TRIANGLES, firsts_.data(), counts_.data(), parts);
        continue;
      }
      // First count in the stencil what is inside, then cover it with the colour and clear the count.
      gl_.Enable(GL_STENCIL_TEST);
      gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
      gl_.StencilFunc(GL_ALWAYS, 1, 0xFF);
      if (batch.kind == Batch::Kind::mask) {
        gl_.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
      } else {
        gl_.StencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
        gl_.StencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
      }
      gl_.MultiDrawArrays(GL_TRIANGLES, firsts_.data(), counts_.data(), parts);
      gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
      gl_.StencilFunc(GL_NOTEQUAL, 0, 0xFF);
      gl_.StencilOp(GL_ZERO, GL_ZERO, GL_ZERO);
      if (c.a < 255) gl_.Enable(GL_BLEND);
      select_covers(batch, covers_[i], strip_top, strip_bottom);
      gl_.MultiDrawArrays(GL_TRIANGLES, firsts_.data(), counts_.data(), static_cast<GLsizei>(firsts_.size()));
      gl_.Disable(GL_BLEND);
      gl_.Disable(GL_STENCIL_TEST);
    }
    gl_.Finish();
  }

  // False when nothing of the clip rectangle lies in the strip.
  bool set_scissor(const std::optional<Rect>& clip, int offset, int rows) const {
    int left = 0, right = width_ * samples_, top = 0, bottom = rows * samples_;
    if (clip) {
      const auto edge = [&](Fixed v) { return floor_div(std::int64_t{v} * samples_ + 128, 256); };
      left = std::max(left, edge(clip->left));
      right = std::min(right, edge(clip->right));
      top = std::max(top, edge(clip->top) - offset);
      bottom = std::min(bottom, edge(clip->bottom) - offset);
    }
    if (left >= right || top >= bottom) return false;
    gl_.Scissor(left, top, right - left, bottom - top);
    return true;
  }

  // The parts that meet the strip, neighbours joined.
  void select(const Batch& batch, Fixed top, Fixed bottom) {
    firsts_.clear();
    counts_.clear();
    for (const Batch::Part& part : batch.parts)
      if (part.bottom >= top && part.top <= bottom) add(part.first, part.count);
  }

  void select_covers(const Batch& batch, std::int32_t first, Fixed top, Fixed bottom) {
    firsts_.clear();
    counts_.clear();
    for (const Rect& cover : batch.covers) {
      if (cover.bottom >= top && cover.top <= bottom) add(first, 6);
      first += 6;
    }
  }

  void add(std::int32_t first, std::int32_t count) {
    if (!firsts_.empty() && firsts_.back() + counts_.back() == first) {
      counts_.back() += count;
      return;
    }
    firsts_.push_back(first);
    counts_.push_back(count);
  }

  // The mean of samples x samples, rounded.
  void average(Image& image, int top, int rows) {
    const std::size_t stride = static_cast<std::size_t>(width_ * samples_) * 4;
    sums_.resize(stride);
    const unsigned n = static_cast<unsigned>(samples_ * samples_);
    const auto samples = static_cast<std::size_t>(samples_);
    for (int row = 0; row < rows; ++row) {
      const std::uint8_t* in = read_.data() + static_cast<std::size_t>(row) * samples * stride;
      std::uint8_t* out = image.rgb.data() + static_cast<std::size_t>(top + row) * static_cast<std::size_t>(width_) * 3;
      for (std::size_t i = 0; i < stride; ++i) sums_[i] = in[i];
      for (std::size_t s = 1; s < samples; ++s) {
        const std::uint8_t* line = in + s * stride;
        for (std::size_t i = 0; i < stride; ++i) sums_[i] = static_cast<std::uint16_t>(sums_[i] + line[i]);
      }
      const std::uint16_t* sum = sums_.data();
      for (int x = 0; x < width_; ++x, out += 3) {
        unsigned r = 0, g = 0, b = 0;
        for (std::size_t s = 0; s < samples; ++s, sum += 4) {
          b += sum[0];
          g += sum[1];
          r += sum[2];
        }
        out[0] = static_cast<std::uint8_t>((r + n / 2) / n);
        out[1] = static_cast<std::uint8_t>((g + n / 2) / n);
        out[2] = static_cast<std::uint8_t>((b + n / 2) / n);
      }
    }
  }
};

// One for each thread that draws, kept for its next figure.
Raster& raster() {
  thread_local std::unique_ptr<Raster> own;
  if (!own) own = std::make_unique<Raster>();
  return *own;
}

}  // namespace

Image rasterise(const Scene& scene) { return raster().draw(scene); }

std::string rasteriser_name() { return raster().renderer(); }

}  // namespace plantloop
