// ZIP archives without compression: as much of the format as NPZ files need.

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

// CRC-32 as in ZIP and PNG.
std::uint32_t crc32(std::string_view bytes, std::uint32_t so_far = 0);

class ZipWriter {
 public:
  // Throws RunError when the archive would pass 4 GB, which plain ZIP cannot hold.
  void add(std::string_view name, std::string_view bytes);
  // The whole archive; the writer is empty afterwards.
  std::string finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc = 0, size = 0, offset = 0;
  };
  std::string out_;
  std::vector<Entry> entries_;
};

// The members of an archive of stored (not compressed) members, as views into it.
struct ZipResult {
  std::map<std::string, std::string_view, std::less<>> members;
  std::string error;  // why there are none, in words that follow "cannot read 'x': "
  bool ok() const { return error.empty(); }
};
ZipResult read_zip(std::string_view archive);

}  // namespace plantloop
