// Byte offsets of a source -> marks.

#include "engine/diagram/places.h"

#include <algorithm>

#include "engine/base/text.h"

namespace plantloop {

Places::Places(const Source& source) : source_(source) {
  const std::string_view text = source.text;
  begins_.reserve(text.size() / 40 + 2);
  begins_.push_back(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
  offset_ = begins_[0];
  for (std::size_t at = text.find('\n'); at != std::string_view::npos; at = text.find('\n', at + 1)) {
    begins_.push_back(at + 1);
  }
}

Mark Places::at(std::size_t offset, std::size_t size) {
  const std::string_view text = source_.text;
  offset = std::clamp(offset, begins_[0], std::max(text.size(), begins_[0]));
  const bool same_line = offset >= offset_ && (line_ + 1 == begins_.size() || offset < begins_[line_ + 1]);
  if (!same_line) {
    // The next lines are the likely ones.
    if (offset < begins_[line_]) line_ = 0;
    for (int tries = 0; tries < 4 && line_ + 1 < begins_.size() && begins_[line_ + 1] <= offset; ++tries) ++line_;
    if (line_ + 1 < begins_.size() && begins_[line_ + 1] <= offset) {
      const auto next = std::upper_bound(begins_.begin(), begins_.end(), offset);
      line_ = static_cast<std::size_t>(next - begins_.begin()) - 1;
    }
    offset_ = begins_[line_];
    column_ = 0;
  }
  column_ += static_cast<std::uint32_t>(count_characters(text.substr(offset_, offset - offset_)));
  offset_ = offset;
  std::string_view rest = text.substr(offset, size);
  rest = rest.substr(0, rest.find_first_of("\r\n"));
  const auto length = std::max<std::size_t>(1, count_characters(rest));
  return {&source_, static_cast<std::uint32_t>(line_ + 1), column_ + 1, static_cast<std::uint32_t>(length)};
}

}  // namespace plantloop
