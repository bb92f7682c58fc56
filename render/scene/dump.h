// A scene as canonical text, and as one number: equal scenes give equal text on every machine.

#pragma once

#include <cstdint>
#include <string>

#include "render/scene/scene.h"

namespace plantloop {

// JSON, one primitive to the line. Lists of more than `longest` points are given as count, hash and ends, so that a
// stored scene stays small and a difference of two is readable; 0 writes all.
std::string to_json(const Scene& scene, std::size_t longest = 0);

// FNV-1a, 64 bit, of the full JSON.
std::uint64_t hash(const Scene& scene);

// FNV-1a, 64 bit, of any bytes.
std::uint64_t fnv1a(const void* data, std::size_t size, std::uint64_t start = 14695981039346656037ull);

}  // namespace plantloop
