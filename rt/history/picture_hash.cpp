#include "rt/history/picture_hash.h"

#include <cstring>
#include <vector>

namespace sideray::rt {
namespace {

void add(uint64_t& hash, uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 32;
}

// Hashes values in several independent chains, so that none waits for the previous value.
template <typename ValueAt>
PictureHash hash_of(size_t count, const ValueAt& value_at) {
  PictureHash hash{1, 2, 3, 4};
  size_t i = 0;
  for (; i + hash.size() <= count; i += hash.size())
    for (size_t k = 0; k < hash.size(); ++k) add(hash[k], value_at(i + k));
  for (size_t k = 0; i + k < count; ++k) add(hash[k], value_at(i + k));
  return hash;
}

// Hashes by rows, so that the result does not depend on the number of threads. hash_row(y) returns the hash of a row.
template <typename HashRow>
PictureHash combine_rows(Executor& executor, uint32_t height, const HashRow& hash_row) {
  std::vector<PictureHash> rows(height);
  executor.run(height, [&](size_t y, uint32_t) { rows[y] = hash_row(y); });
  PictureHash hash{};
  for (const PictureHash& row : rows)
    for (size_t k = 0; k < hash.size(); ++k) add(hash[k], row[k]);
  return hash;
}

template <typename T>
T texel_at(const std::byte* texels, size_t index) {
  T value;
  std::memcpy(&value, texels + index * sizeof(T), sizeof(T));
  return value;
}

PictureHash hash_depth_row(const std::byte* row, DepthFormat format, uint32_t width, uint32_t bits) {
  switch (format) {
    case DepthFormat::d16:
      return hash_of(width, [&](size_t x) { return uint64_t{texel_at<uint16_t>(row, x)}; });
    case DepthFormat::d24s8:
      return hash_of(width, [&](size_t x) { return uint64_t{texel_at<uint32_t>(row, x) & (0xffffff00u | bits)}; });
    case DepthFormat::d24:
    case DepthFormat::d32f:
      return hash_of(width, [&](size_t x) { return uint64_t{texel_at<uint32_t>(row, x)}; });
    default:
      return hash_of(width, [&](size_t x) { return texel_at<uint64_t>(row, x) & (uint64_t{bits} << 32 | 0xffffffffu); });
  }
}

}  // namespace

PictureHash hash_depth(Executor& executor, const DepthImage& depth, uint32_t width, uint32_t height,
                       uint32_t stencil_bits) {
  if (!depth.texels) return {};
  return combine_rows(executor, height, [&](size_t y) {
    return hash_depth_row(depth.texels + y * depth.row_bytes, depth.format, width, stencil_bits & 0xffu);
  });
}

PictureHash hash_rows(Executor& executor, std::span<const std::byte> texels, uint32_t rows) {
  if (texels.empty() || rows == 0) return {};
  const size_t row_bytes = texels.size() / rows, words = row_bytes / sizeof(uint64_t);
  return combine_rows(executor, rows, [&](size_t y) {
    const std::byte* row = texels.data() + y * row_bytes;
    PictureHash hash = hash_of(words, [&](size_t i) { return texel_at<uint64_t>(row, i); });
    uint64_t rest = 0;
    std::memcpy(&rest, row + words * sizeof(uint64_t), row_bytes - words * sizeof(uint64_t));
    add(hash[0], rest);
    return hash;
  });
}

}  // namespace sideray::rt
