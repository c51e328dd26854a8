#include "gl/scene/kept_casters.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

namespace sideray::gl {
namespace {

template <typename T>
bool same_memory(const T& a, const T& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// Returns the texture that cuts holes into surfaces of a material; null: none does.
const void* cut_out_by(const model::Snapshot& s, const model::Material& material) {
  const uint32_t texture = material.desc.base_color_texture.texture;
  return material.discards && texture != 0 ? s.textures[texture - 1].get() : nullptr;
}

// `wind`: index + 1.
bool blows_the_same(const model::Snapshot& a, const model::Snapshot& b, uint32_t wind) {
  return a.time_s == b.time_s && same_memory(a.winds[wind - 1], b.winds[wind - 1]);
}

// Padding bytes may differ too, which only causes a redundant draw.
bool casts_the_same(const model::Snapshot& a, const model::Snapshot& b, uint32_t instance) {
  const model::Instance &i = a.instances[instance], &k = b.instances[instance];
  if (!same_memory(i, k) || a.meshes[i.mesh] != b.meshes[k.mesh]) return false;
  const model::Material &m = a.materials[i.material], &n = b.materials[k.material];
  if (!same_memory(m, n) || cut_out_by(a, m) != cut_out_by(b, n)) return false;
  return i.wind == 0 || blows_the_same(a, b, i.wind);
}

}  // namespace

bool LayerCasters::begin(const glm::mat4& clip_from_local, size_t places) {
  const size_t words = (places + 63) / 64;
  if (known_ && clip_from_local_ == clip_from_local && drawn_.size() == words) return true;
  known_ = true;
  clip_from_local_ = clip_from_local;
  drawn_.assign(words, 0);
  outside_.assign(words, 0);
  return false;
}

bool LayerCasters::are_settled(uint32_t first, uint32_t count) const {
  for (uint32_t place = first; place < first + count;) {
    if (place % 64 == 0 && place + 64 <= first + count && is_block_settled(place / 64)) {
      place += 64;
      continue;
    }
    if (!is_settled(place)) return false;
    ++place;
  }
  return true;
}

void LayerCasters::change(uint32_t place) {
  if (!known_) return;
  const uint64_t bit = uint64_t{1} << (place % 64);
  if (drawn_[place / 64] & bit) return forget();
  outside_[place / 64] &= ~bit;
}

CasterChanges::Changes CasterChanges::take(const RasterScene& scene) {
  std::shared_ptr<const model::Snapshot> now = scene.shared_snapshot();
  const std::span<const uint32_t> order = scene.instance_order();
  const bool same_places = before_ && std::ranges::equal(order_, order);
  Changes changes{!same_places, {}};
  if (same_places) changes.places = scene.kept_surfaces() ? swaying(scene) : compare(*now);
  if (!same_places) order_.assign(order.begin(), order.end());
  before_ = std::move(now);
  return changes;
}

std::vector<uint32_t> CasterChanges::compare(const model::Snapshot& now) const {
  std::vector<uint32_t> places;
  for (uint32_t place = 0; place < order_.size(); ++place)
    if (!casts_the_same(*before_, now, order_[place])) places.push_back(place);
  return places;
}

// Returns the places of instances whose wind differs from that of the scene before, so that they have moved.
std::vector<uint32_t> CasterChanges::swaying(const RasterScene& scene) const {
  std::vector<uint32_t> places;
  for (const Draw& draw : scene.opaque()) {
    if (draw.wind == 0 || blows_the_same(*before_, scene.snapshot(), draw.wind)) continue;
    for (uint32_t i = 0; i < draw.instance_count; ++i) places.push_back(draw.first_instance + i);
  }
  return places;
}

}  // namespace sideray::gl
