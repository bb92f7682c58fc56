// PNG by libpng: no filter, level 8, the resolution, no time: equal pictures give equal files.

#include <png.h>

#include <cmath>
#include <csetjmp>
#include <string>

#include "render/backend/backend.h"
#include "render/error.h"
#include "render/image.h"

namespace plantloop {
namespace {

struct Encoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~Encoder() { png_destroy_write_struct(&png, &info); }
};

void take(png_structp png, png_bytep data, png_size_t size) {
  auto* out = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  out->insert(out->end(), data, data + size);
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image, double dpi) {
  std::vector<std::uint8_t> out;
  std::vector<png_bytep> rows;
  const auto stride = static_cast<std::size_t>(image.width) * 3;
  for (int y = 0; y < image.height; ++y)
    rows.push_back(const_cast<png_bytep>(image.rgb.data() + static_cast<std::size_t>(y) * stride));
  Encoder encoder;
  encoder.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  if (encoder.png) encoder.info = png_create_info_struct(encoder.png);
  if (!encoder.info) throw RenderError("libpng does not start");
  if (setjmp(png_jmpbuf(encoder.png))) throw RenderError("libpng cannot write the picture");  // NOLINT
  png_set_write_fn(encoder.png, &out, take, nullptr);
  png_set_IHDR(encoder.png, encoder.info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
               8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  const auto per_metre = static_cast<png_uint_32>(std::lround(dpi / 0.0254));
  png_set_pHYs(encoder.png, encoder.info, per_metre, per_metre, PNG_RESOLUTION_METER);
  png_set_filter(encoder.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_set_compression_level(encoder.png, 8);
  png_set_rows(encoder.png, encoder.info, rows.data());
  png_write_png(encoder.png, encoder.info, PNG_TRANSFORM_IDENTITY, nullptr);
  return out;
}

Image decode_png(std::span<const std::uint8_t> bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
    throw RenderError(std::string("this is no PNG file: ") + png.message);
  png.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  const png_color white{255, 255, 255};
  if (!png_image_finish_read(&png, &white, image.rgb.data(), 0, nullptr))
    throw RenderError(std::string("this PNG file is damaged: ") + png.message);
  return image;
}

std::vector<std::uint8_t> to_png(const Scene& scene) { return encode_png(rasterise(scene), scene.dpi); }

extern const Backend backend_png;
const Backend backend_png{"png", to_png};

}  // namespace plantloop
