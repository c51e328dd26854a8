#include "rt/light/veils.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

constexpr uint32_t most_layers = 16;
// A pixel has few rays for half the sky, so each represents a wide cone, and textures are read as coarsely.
constexpr Cone wide{0.0f, 0.5f};

// Leaves out what wind moves: it moves between commits, and only commits invalidate reused masks.
bool is_veil(const model::Instance& instance) {
  return instance.wind == 0 && (instance.visibility & SIDERAY_VISIBLE_AO) != 0;
}

}  // namespace

bool veils_sky(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(), [&](const model::Instance& instance) {
    return instance.sprites == 0 && is_veil(instance) && snapshot.materials[instance.material].translucent;
  });
}

void Veils::meet(const ShadingScene& scene, const Intersector& intersector, std::span<const Ray> rays, bool coherent) {
  hits_.resize(rays.size() * most_layers);
  counts_.resize(rays.size());
  intersector.nearest_layers(LayerSet::all_translucent, rays, {.layers = most_layers, .coherent = coherent},
                             hits_.data(), counts_.data());
  places_.clear();
  of_places_.clear();
  for (size_t r = 0; r < rays.size(); ++r)
    for (uint32_t k = 0; k < counts_[r]; ++k) {
      const Hit& hit = hits_[r * most_layers + k];
      if (!is_veil(scene.snapshot->instances[hit.instance])) continue;
      places_.push_back({&hit, &rays[r], wide});
      of_places_.push_back(static_cast<uint32_t>(r));
    }
  points_.resize(places_.size());
  make_surfaces(scene, shade_kernels(intersector.isa().c_str()), places_, points_.data());
  colors_.assign(rays.size(), glm::vec3(1.0f));
  distance_.assign(rays.size(), INFINITY);
  for (size_t i = 0; i < points_.size(); ++i) {
    const uint32_t r = of_places_[i];
    if (points_[i].blended.through == glm::vec3(1.0f)) continue;
    colors_[r] *= points_[i].blended.through;
    distance_[r] = std::min(distance_[r], static_cast<float>(places_[i].hit->distance));
  }
  through_.resize(rays.size());
  for (size_t r = 0; r < rays.size(); ++r) {
    const glm::vec3 c = colors_[r] = glm::clamp(colors_[r], 0.0f, 1.0f);
    through_[r] = (c.x + c.y + c.z) * (1.0f / 3.0f);
  }
}

}  // namespace sideray::rt
