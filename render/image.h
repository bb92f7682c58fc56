// Scene -> picture. Bytes are returned, never written: the caller decides about files.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

// Three bytes to the pixel, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

// The pixels of a scene, drawn by OSMesa, or by EGL where OSMesa is missing; it is loaded when the first picture is
// asked for and kept for the next. The same scene gives the same bits at every number of threads and through either
// door; the environment variable PLANTLOOP_GL, osmesa or egl, chooses one. Throws RenderError when neither is
// installed.
Image rasterise(const Scene& scene);

// Who draws: "llvmpipe (LLVM 15.0.6, 256 bits)". Stored hashes of pixels are only worth comparing for llvmpipe.
std::string rasteriser_name();

std::vector<std::uint8_t> encode_png(const Image& image, double dpi);
std::vector<std::uint8_t> to_png(const Scene& scene);

// Any PNG as opaque pixels (what is transparent lies on white). Throws RenderError for bytes that are no PNG.
Image decode_png(std::span<const std::uint8_t> bytes);

// Text as glyph outlines with the words beside them (aria-label), so that it looks the same everywhere.
std::string to_svg(const Scene& scene);

// One page to the scene, of the scene's size; fonts are embedded and text can be searched and copied.
std::string to_pdf(std::span<const Scene> pages);

// By the name of a format, which is also the file's ending: one of `picture_formats`. Throws RenderError for others.
std::vector<std::uint8_t> picture(const Scene& scene, std::string_view format);
std::vector<std::string> picture_formats();

}  // namespace plantloop
