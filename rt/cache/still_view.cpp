#include "rt/cache/still_view.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "rt/cache/temporal_history.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

void mix(uint64_t& hash, uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 32;
}

// Hashes the depth and stencil of a row: what a format leaves undefined does not count.
uint64_t hash_of_row(const CacheRequest& r, uint32_t y, uint64_t hash) {
  const std::byte* row = r.depth.texels + y * r.depth.row_bytes;
  const bool narrow = r.depth.format == DepthFormat::d16, wide = r.depth.format == DepthFormat::d32f_s8;
  const size_t size = narrow ? 2 : wide ? 8 : 4;
  for (uint32_t x = 0; x < r.width; ++x) {
    uint64_t texel = 0;
    std::memcpy(&texel, row + x * size, size);
    mix(hash, wide ? texel & 0xffffffffffu : texel);
  }
  return hash;
}

// Returns whether all options of requests agree that layers depend on, but for pictures.
bool same_options(const CacheRequest& a, const CacheRequest& b) {
  return a.view.clip_from_local == b.view.clip_from_local && a.view.local_from_clip == b.view.local_from_clip &&
         a.view.reversed_depth == b.view.reversed_depth && a.view.zero_to_one_depth == b.view.zero_to_one_depth &&
         a.width == b.width && a.height == b.height && a.depth.format == b.depth.format && a.mask == b.mask &&
         a.stencil_bits == b.stencil_bits && a.shadows == b.shadows && a.seed == b.seed && a.subpixel == b.subpixel &&
         ask_alike(a, b);
}

}  // namespace

bool StillView::is_last(const CacheRequest& request, const model::Snapshot& committed,
                        const PictureHash& picture) const {
  if (!committed_ || request.sequence != SequenceStep::next || picture != picture_) return false;
  if (!committed.winds.empty() || !committed.particles.empty() || !same_options(request_, request)) return false;
  return are_equal(*committed_, committed);
}

uint32_t StillView::learn(const CacheRequest& request, std::shared_ptr<const model::Snapshot> committed,
                          Executor& executor) {
  if (request.sequence == SequenceStep::again) return 0;
  std::vector<PictureHash> rows(request.height, PictureHash{1, 2});
  executor.run(request.height, [&](size_t y, uint32_t) {
    if (request.depth.texels) rows[y][0] = hash_of_row(request, static_cast<uint32_t>(y), 1);
    if (!request.mask_bytes.empty())
      for (const uint8_t byte : request.mask_bytes.subspan(y * request.width, request.width)) mix(rows[y][1], byte);
  });
  PictureHash picture{};
  for (const PictureHash& row : rows)
    for (size_t k = 0; k < picture.size(); ++k) mix(picture[k], row[k]);
  frames_ = is_last(request, *committed, picture) ? frames_ + 1 : 0;
  request_ = request;
  committed_ = std::move(committed);
  picture_ = picture;
  return frames_;
}

}  // namespace sideray::rt
