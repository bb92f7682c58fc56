// ZIP archives without compression (PKWARE, .ZIP File Format Specification, 4.3).

#include "engine/run/zip.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "engine/base/error.h"

namespace plantloop {
namespace {

constexpr std::uint32_t local_magic = 0x04034b50, central_magic = 0x02014b50, end_magic = 0x06054b50;
constexpr std::size_t local_size = 30, central_size = 46, end_size = 22;
constexpr std::uint16_t version = 20, utf8_names = 0x0800;
constexpr std::uint16_t new_year_1980 = 0x21;  // a fixed date: equal recordings give equal files

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr Tables crc_tables() {
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1U) ^ ((rest & 1U) != 0 ? 0xEDB88320U : 0U);
    tables[0][byte] = rest;
  }
  for (std::size_t table = 1; table < 8; ++table) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[table - 1][byte];
      tables[table][byte] = (before >> 8U) ^ tables[0][before & 0xFFU];
    }
  }
  return tables;
}

template <typename T>
void put(std::string& out, T value) {
  for (std::size_t byte = 0; byte < sizeof(T); ++byte) out += static_cast<char>((value >> (8 * byte)) & 0xFFU);
}

template <typename T>
T get(std::string_view bytes, std::size_t at) {
  T value = 0;
  for (std::size_t byte = 0; byte < sizeof(T); ++byte) {
    value = static_cast<T>(value |
                           static_cast<T>(static_cast<T>(static_cast<unsigned char>(bytes[at + byte])) << (8 * byte)));
  }
  return value;
}

}  // namespace

// Eight bytes at a time, a table for the place of each ("slicing by eight").
std::uint32_t crc32(std::string_view bytes, std::uint32_t so_far) {
  static constexpr Tables tables = crc_tables();
  std::uint32_t rest = ~so_far;
  while (bytes.size() >= 8) {
    const std::uint32_t low = rest ^ get<std::uint32_t>(bytes, 0);
    const auto high = get<std::uint32_t>(bytes, 4);
    rest = tables[7][low & 0xFFU] ^ tables[6][(low >> 8U) & 0xFFU] ^ tables[5][(low >> 16U) & 0xFFU] ^
           tables[4][low >> 24U] ^ tables[3][high & 0xFFU] ^ tables[2][(high >> 8U) & 0xFFU] ^
           tables[1][(high >> 16U) & 0xFFU] ^ tables[0][high >> 24U];
    bytes.remove_prefix(8);
  }
  for (const char c : bytes) rest = (rest >> 8U) ^ tables[0][(rest ^ static_cast<unsigned char>(c)) & 0xFFU];
  return ~rest;
}

void ZipWriter::add(std::string_view name, std::string_view bytes) {
  const std::size_t directory = (entries_.size() + 1) * 256;
  if (out_.size() + bytes.size() + directory > std::numeric_limits<std::uint32_t>::max() ||
      entries_.size() + 1 >= std::numeric_limits<std::uint16_t>::max()) {
    throw RunError("an NPZ file cannot hold more than 4 GB or 65534 arrays; write CSV, or record less");
  }
  const Entry entry{std::string(name), crc32(bytes), static_cast<std::uint32_t>(bytes.size()),
                    static_cast<std::uint32_t>(out_.size())};
  put(out_, local_magic);
  put(out_, version);
  put(out_, utf8_names);
  put<std::uint16_t>(out_, 0);  // stored
  put<std::uint16_t>(out_, 0);  // time
  put(out_, new_year_1980);
  put(out_, entry.crc);
  put(out_, entry.size);
  put(out_, entry.size);
  put(out_, static_cast<std::uint16_t>(name.size()));
  put<std::uint16_t>(out_, 0);  // no extra field
  out_ += name;
  out_ += bytes;
  entries_.push_back(entry);
}

std::string ZipWriter::finish() {
  const std::size_t start = out_.size();
  for (const Entry& entry : entries_) {
    put(out_, central_magic);
    put(out_, version);
    put(out_, version);
    put(out_, utf8_names);
    put<std::uint16_t>(out_, 0);
    put<std::uint16_t>(out_, 0);
    put(out_, new_year_1980);
    put(out_, entry.crc);
    put(out_, entry.size);
    put(out_, entry.size);
    put(out_, static_cast<std::uint16_t>(entry.name.size()));
    put<std::uint16_t>(out_, 0);  // extra field, comment, disk, inner attributes
    put<std::uint16_t>(out_, 0);
    put<std::uint16_t>(out_, 0);
    put<std::uint16_t>(out_, 0);
    put<std::uint32_t>(out_, 0);  // outer attributes
    put(out_, entry.offset);
    out_ += entry.name;
  }
  const std::size_t size = out_.size() - start;
  put(out_, end_magic);
  put<std::uint16_t>(out_, 0);
  put<std::uint16_t>(out_, 0);
  put(out_, static_cast<std::uint16_t>(entries_.size()));
  put(out_, static_cast<std::uint16_t>(entries_.size()));
  put(out_, static_cast<std::uint32_t>(size));
  put(out_, static_cast<std::uint32_t>(start));
  put<std::uint16_t>(out_, 0);
  entries_.clear();
  return std::move(out_);
}

ZipResult read_zip(std::string_view archive) {
  ZipResult result;
  const auto fail = [&](std::string why) {
    result.members.clear();
    result.error = std::move(why);
    return result;
  };
  // The end record stands last, before a comment of at most 65535 bytes.
  std::size_t end = archive.size() < end_size ? 0 : archive.size() - end_size;
  const std::size_t lowest = end > 0xFFFF ? end - 0xFFFF : 0;
  if (archive.size() < end_size) return fail("it is no ZIP archive");
  while (get<std::uint32_t>(archive, end) != end_magic) {
    if (end == lowest) return fail("it is no ZIP archive, or its end is missing");
    --end;
  }
  const std::size_t count = get<std::uint16_t>(archive, end + 10);
  std::size_t at = get<std::uint32_t>(archive, end + 16);
  for (std::size_t i = 0; i < count; ++i) {
    if (at + central_size > archive.size() || get<std::uint32_t>(archive, at) != central_magic) {
      return fail("its list of members is damaged");
    }
    const std::size_t size = get<std::uint32_t>(archive, at + 24);
    const std::size_t name_length = get<std::uint16_t>(archive, at + 28);
    const std::size_t local = get<std::uint32_t>(archive, at + 42);
    if (at + central_size + name_length > archive.size() || local + local_size > archive.size()) {
      return fail("its list of members is damaged");
    }
    const std::string name(archive.substr(at + central_size, name_length));
    if (get<std::uint16_t>(archive, at + 10) != 0) return fail(fmt::format("member '{}' is compressed", name));
    const std::size_t begin =
        local + local_size + get<std::uint16_t>(archive, local + 26) + get<std::uint16_t>(archive, local + 28);
    if (begin + size > archive.size()) return fail(fmt::format("member '{}' is cut off", name));
    const std::string_view bytes = archive.substr(begin, size);
    if (crc32(bytes) != get<std::uint32_t>(archive, at + 16)) return fail(fmt::format("member '{}' is damaged", name));
    result.members.emplace(name, bytes);
    at += central_size + name_length + get<std::uint16_t>(archive, at + 30) + get<std::uint16_t>(archive, at + 32);
  }
  return result;
}

}  // namespace plantloop
