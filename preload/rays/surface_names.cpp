#include "preload/rays/surface_names.h"

namespace sideray::run {
namespace {

constexpr uint32_t largest = (1u << 23) - 1;  // ids are up to twice this number, and floats hold those exactly

}  // namespace

void SurfaceNames::begin_frame() {
  old_meshes_ = std::move(meshes_);
  old_textures_ = std::move(textures_);
  meshes_.clear();
  textures_.clear();
  taken_.clear();
}

uint32_t SurfaceNames::take_old(Names& names, uint64_t key) {
  const auto [first, last] = names.equal_range(key);
  for (auto at = first; at != last; ++at)
    if (taken_.insert(at->second).second) return at->second;
  return 0;
}

uint32_t SurfaceNames::name(uint64_t mesh, uint64_t texture) {
  uint32_t id = take_old(old_meshes_, mesh);
  if (id == 0 && texture != 0) id = take_old(old_textures_, texture);
  while (id == 0) {
    const uint32_t candidate = next_;
    next_ = next_ == largest ? 1 : next_ + 1;
    if (taken_.insert(candidate).second) id = candidate;
  }
  meshes_.emplace(mesh, id);
  textures_.emplace(texture, id);
  return id;
}

}  // namespace sideray::run
