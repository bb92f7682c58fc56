// Font subsets by HarfBuzz, without the tables that only shaping needs: what is embedded has been shaped already.

#include "render/text/subset.h"

#include <hb-ot.h>
#include <hb-subset.h>
#include <hb.h>

#include <memory>

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
using Blob = std::unique_ptr<hb_blob_t, Destroy<hb_blob_destroy>>;
using FontFace = std::unique_ptr<hb_face_t, Destroy<hb_face_destroy>>;
using Input = std::unique_ptr<hb_subset_input_t, Destroy<hb_subset_input_destroy>>;
using CutPlan = std::unique_ptr<hb_subset_plan_t, Destroy<hb_subset_plan_destroy>>;
using SizedFont = std::unique_ptr<hb_font_t, Destroy<hb_font_destroy>>;

std::string bytes_of(hb_blob_t* blob) {
  unsigned size = 0;
  const char* data = hb_blob_get_data(blob, &size);
  return {data, size};
}

// A variable font becomes one with the weight that figures use.
void pin_axes(hb_subset_input_t* input, hb_face_t* face, int weight) {
  const unsigned count = hb_ot_var_get_axis_count(face);
  for (unsigned i = 0; i < count; ++i) {
    unsigned one = 1;
    hb_ot_var_axis_info_t axis;
    if (hb_ot_var_get_axis_infos(face, i, &one, &axis) == 0 || one == 0) continue;
    if (axis.tag == HB_TAG('w', 'g', 'h', 't') && weight > 0) {
      hb_subset_input_pin_axis_location(input, face, axis.tag, static_cast<float>(weight));
    } else {
      hb_subset_input_pin_axis_to_default(input, face, axis.tag);
    }
  }
}

void drop_shaping(hb_subset_input_t* input) {
  hb_set_t* dropped = hb_subset_input_set(input, HB_SUBSET_SETS_DROP_TABLE_TAG);
  for (const char* tag : {"GSUB", "GPOS", "GDEF", "kern", "name", "post", "OS/2", "cmap", "STAT", "MATH", "DSIG"})
    hb_set_add(dropped, hb_tag_from_string(tag, -1));
}

std::int16_t signed_at(const std::string& table, std::size_t at) {
  if (at + 2 > table.size()) return 0;
  return static_cast<std::int16_t>(static_cast<std::uint8_t>(table[at]) << 8 |
                                   static_cast<std::uint8_t>(table[at + 1]));
}

}  // namespace

SubsetFont subset(int font, const std::set<std::uint32_t>& glyphs) {
  const EmbeddedFont embedded = embedded_fonts()[static_cast<std::size_t>(font)];
  const Blob blob(hb_blob_create(reinterpret_cast<const char*>(embedded.bytes.data()),
                                 static_cast<unsigned>(embedded.bytes.size()), HB_MEMORY_MODE_READONLY, nullptr,
                                 nullptr));
  const FontFace face(hb_face_create(blob.get(), 0));
  const Input input(hb_subset_input_create_or_fail());
  if (!input) throw RenderError("HarfBuzz cannot cut fonts");
  for (const std::uint32_t glyph : glyphs) hb_set_add(hb_subset_input_glyph_set(input.get()), glyph);
  pin_axes(input.get(), face.get(), embedded.weight);
  drop_shaping(input.get());
  hb_subset_input_set_flags(input.get(), HB_SUBSET_FLAGS_NO_HINTING);
  const CutPlan plan(hb_subset_plan_create_or_fail(face.get(), input.get()));
  const FontFace cut(plan ? hb_subset_plan_execute_or_fail(plan.get()) : nullptr);
  if (!cut) throw RenderError("HarfBuzz cannot cut the font " + std::string(embedded.name));

  SubsetFont result;
  const hb_map_t* map = hb_subset_plan_old_to_new_glyph_mapping(plan.get());
  for (const std::uint32_t glyph : glyphs) result.glyphs[glyph] = hb_map_get(map, glyph);
  const Blob cff(hb_face_reference_table(cut.get(), HB_TAG('C', 'F', 'F', ' ')));
  result.is_cff = hb_blob_get_length(cff.get()) > 0;
  if (result.is_cff) {
    result.program = bytes_of(cff.get());
  } else {
    const Blob whole(hb_face_reference_blob(cut.get()));
    result.program = bytes_of(whole.get());
  }

  const double to_thousandths = 1000.0 / hb_face_get_upem(cut.get());
  const SizedFont sized(hb_font_create(cut.get()));
  const int upem = static_cast<int>(hb_face_get_upem(cut.get()));
  hb_font_set_scale(sized.get(), upem, upem);
  for (unsigned i = 0; i < hb_face_get_glyph_count(cut.get()); ++i)
    result.advances.push_back(hb_font_get_glyph_h_advance(sized.get(), i) * to_thousandths);
  hb_font_extents_t extents;
  hb_font_get_h_extents(sized.get(), &extents);
  result.ascent = extents.ascender * to_thousandths;
  result.descent = extents.descender * to_thousandths;
  result.cap_height = 727;
  const Blob head(hb_face_reference_table(cut.get(), HB_TAG('h', 'e', 'a', 'd')));
  const std::string table = bytes_of(head.get());
  for (std::size_t i = 0; i < 4; ++i) result.box[i] = signed_at(table, 36 + 2 * i) * to_thousandths;
  return result;
}

}  // namespace plantloop
