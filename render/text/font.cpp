// Fonts by FreeType (outlines) and HarfBuzz (shaping).

#include "render/text/font.h"

#include <ft2build.h>
#include <hb-ot.h>
#include <hb.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <unordered_map>
#include FT_FREETYPE_H
#include FT_MULTIPLE_MASTERS_H
#include FT_OUTLINE_H

#include "render/error.h"
#include "render/text/embedded_fonts.h"

namespace plantloop {
namespace {

template <auto destroy>
struct Destroy {
  template <typename T>
  void operator()(T* object) const {
    destroy(object);
  }
};

struct Face {
  FT_Face ft = nullptr;
  std::unique_ptr<hb_font_t, Destroy<hb_font_destroy>> hb;
  std::unordered_map<std::uint32_t, std::unique_ptr<Outline>> outlines;
};

// Puts the weight axis of a variable font to the weight, other axes to their defaults.
void set_weight(FT_Library library, Face& face, int weight) {
  FT_MM_Var* axes = nullptr;
  if (FT_Get_MM_Var(face.ft, &axes) != 0) return;
  std::vector<FT_Fixed> coordinates;
  for (FT_UInt i = 0; i < axes->num_axis; ++i) {
    const bool is_weight = axes->axis[i].tag == FT_MAKE_TAG('w', 'g', 'h', 't');
    coordinates.push_back(is_weight ? FT_Fixed{weight} * 65536 : axes->axis[i].def);
  }
  FT_Set_Var_Design_Coordinates(face.ft, axes->num_axis, coordinates.data());
  FT_Done_MM_Var(library, axes);
  const hb_variation_t variation{HB_TAG('w', 'g', 'h', 't'), static_cast<float>(weight)};
  hb_font_set_variations(face.hb.get(), &variation, 1);
}

struct Store {
  FT_Library library = nullptr;
  std::array<Face, font_count> faces;
  std::mutex mutex;

  Store() {
    if (FT_Init_FreeType(&library) != 0) throw RenderError("FreeType does not start");
    const auto fonts = embedded_fonts();
    for (std::size_t i = 0; i < fonts.size(); ++i) open(faces[i], fonts[i]);
  }
  ~Store() {
    for (Face& face : faces) FT_Done_Face(face.ft);
    FT_Done_FreeType(library);
  }
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  void open(Face& face, const EmbeddedFont& font) {
    if (FT_New_Memory_Face(library, font.bytes.data(), static_cast<FT_Long>(font.bytes.size()), 0, &face.ft) != 0)
      throw RenderError("FreeType cannot read the embedded font " + std::string(font.name));
    hb_blob_t* blob =
        hb_blob_create(reinterpret_cast<const char*>(font.bytes.data()), static_cast<unsigned>(font.bytes.size()),
                       HB_MEMORY_MODE_READONLY, nullptr, nullptr);
    hb_face_t* hb_face = hb_face_create(blob, 0);
    face.hb.reset(hb_font_create(hb_face));
    hb_face_destroy(hb_face);
    hb_blob_destroy(blob);
    hb_font_set_scale(face.hb.get(), face.ft->units_per_EM, face.ft->units_per_EM);
    hb_ot_font_set_funcs(face.hb.get());
    if (font.weight > 0) set_weight(library, face, font.weight);
    hb_font_make_immutable(face.hb.get());
  }
};

Store& store() {
  static Store only;
  return only;
}

OutlineStep step_to(OutlineStep::Kind kind, const FT_Vector* to) {
  return {kind, static_cast<std::int32_t>(to->x), static_cast<std::int32_t>(to->y)};
}

Outline read_outline(FT_Face face, std::uint32_t glyph) {
  Outline result;
  if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_SCALE | FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0) return result;
  if (face->glyph->format != FT_GLYPH_FORMAT_OUTLINE || face->glyph->outline.n_points == 0) return result;
  FT_Outline_Funcs pen{};
  pen.move_to = [](const FT_Vector* to, void* out) {
    static_cast<Outline*>(out)->steps.push_back(step_to(OutlineStep::move, to));
    return 0;
  };
  pen.line_to = [](const FT_Vector* to, void* out) {
    static_cast<Outline*>(out)->steps.push_back(step_to(OutlineStep::line, to));
    return 0;
  };
  pen.conic_to = [](const FT_Vector* control, const FT_Vector* to, void* out) {
    OutlineStep step = step_to(OutlineStep::quadratic, to);
    step.x1 = static_cast<std::int32_t>(control->x);
    step.y1 = static_cast<std::int32_t>(control->y);
    static_cast<Outline*>(out)->steps.push_back(step);
    return 0;
  };
  pen.cubic_to = [](const FT_Vector* one, const FT_Vector* two, const FT_Vector* to, void* out) {
    OutlineStep step = step_to(OutlineStep::cubic, to);
    step.x1 = static_cast<std::int32_t>(one->x);
    step.y1 = static_cast<std::int32_t>(one->y);
    step.x2 = static_cast<std::int32_t>(two->x);
    step.y2 = static_cast<std::int32_t>(two->y);
    static_cast<Outline*>(out)->steps.push_back(step);
    return 0;
  };
  FT_Outline_Decompose(&face->glyph->outline, &pen, &result);
  FT_BBox box;
  FT_Outline_Get_CBox(&face->glyph->outline, &box);
  result.left = static_cast<std::int32_t>(box.xMin);
  result.bottom = static_cast<std::int32_t>(box.yMin);
  result.right = static_cast<std::int32_t>(box.xMax);
  result.top = static_cast<std::int32_t>(box.yMax);
  return result;
}

Face& face_of(int font) { return store().faces.at(static_cast<std::size_t>(font)); }

}  // namespace

int units_per_em(int font) { return face_of(font).ft->units_per_EM; }

const Outline& outline(int font, std::uint32_t glyph) {
  Face& face = face_of(font);
  const std::lock_guard lock(store().mutex);
  auto& entry = face.outlines[glyph];
  if (!entry) entry = std::make_unique<Outline>(read_outline(face.ft, glyph));
  return *entry;
}

bool has_glyph(int font, char32_t character) {
  hb_codepoint_t glyph = 0;
  return hb_font_get_nominal_glyph(face_of(font).hb.get(), character, &glyph) != 0;
}

Shaped shape(int font, std::u32string_view text, bool tabular) {
  static_assert(sizeof(char32_t) == sizeof(std::uint32_t));
  Face& face = face_of(font);
  const std::lock_guard lock(store().mutex);
  const std::unique_ptr<hb_buffer_t, Destroy<hb_buffer_destroy>> buffer(hb_buffer_create());
  hb_buffer_add_utf32(buffer.get(), reinterpret_cast<const std::uint32_t*>(text.data()), static_cast<int>(text.size()),
                      0, static_cast<int>(text.size()));
  hb_buffer_set_direction(buffer.get(), HB_DIRECTION_LTR);
  hb_buffer_set_script(buffer.get(), HB_SCRIPT_LATIN);
  hb_buffer_set_language(buffer.get(), hb_language_from_string("en", -1));
  const hb_feature_t digits{HB_TAG('t', 'n', 'u', 'm'), tabular ? 1u : 0u, 0, static_cast<unsigned>(-1)};
  hb_shape(face.hb.get(), buffer.get(), &digits, 1);

  Shaped result;
  unsigned count = 0;
  const hb_glyph_info_t* infos = hb_buffer_get_glyph_infos(buffer.get(), &count);
  const hb_glyph_position_t* positions = hb_buffer_get_glyph_positions(buffer.get(), &count);
  for (unsigned i = 0; i < count; ++i) {
    result.glyphs.push_back({infos[i].codepoint, result.advance + positions[i].x_offset, positions[i].y_offset});
    result.advance += positions[i].x_advance;
  }
  return result;
}

std::vector<SceneFont> scene_fonts() {
  std::vector<SceneFont> result;
  for (const EmbeddedFont& font : embedded_fonts())
    result.push_back({std::string(font.name), std::string(font.sha256)});
  return result;
}

}  // namespace plantloop
