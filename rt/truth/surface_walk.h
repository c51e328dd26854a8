// Finds all surfaces of one kind along each ray, coplanar ones too, however many there are. It has scratch memory: one
// object per thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/embree/recompute.h"

namespace sideray::rt {

class SurfaceWalk {
 public:
  // All rays use `cone` for alpha. cull: skips backs of materials that are not double sided.
  SurfaceWalk(const model::Snapshot& snapshot, const Intersector& intersector, const AlphaCone& cone, bool cull)
      : snapshot_(snapshot), intersector_(intersector), cone_(cone), cull_(cull) {}

  // Call met(ray index, hit) for each surface, in the total order of Intersector::nearest_layers(). A ray ends if it
  // returns false.
  template <typename Met>
  void opaque(std::span<const Ray> rays, const Met& met) {
    walk(rays, met, [this](uint32_t layers) {
      intersector_.nearest_opaque_layers(rays_, {.layers = layers, .coherent = true, .cone = cone_, .cull = cull_},
                                         hits_.data(), counts_.data());
    });
  }
  template <typename Met>
  void translucent(std::span<const Ray> rays, const Met& met) {
    walk(rays, met, [this](uint32_t layers) {
      intersector_.nearest_layers(LayerSet::all_translucent, rays_,
                                  {.layers = layers, .coherent = true, .cone = cone_, .cull = cull_}, hits_.data(),
                                  counts_.data());
    });
  }

 private:
  // Number of surfaces searched in a round; more if all are at one distance.
  static constexpr uint32_t surfaces_in_round = 8, most_surfaces_in_round = 64;
  // A further round starts before the last surface, by this share of its distance; the total order tells which surfaces
  // are known.
  static constexpr double back_step = 1e-6;

  // Describes a ray that needs further rounds.
  struct OpenRay {
    uint32_t index;
    Ray ray;
    Hit last;
  };
  struct Taken {
    bool any, goes_on;
  };

  template <typename Met, typename Round>
  void walk(std::span<const Ray> rays, const Met& met, const Round& round) {
    open_.clear();
    for (uint32_t i = 0; i < rays.size(); ++i) open_.push_back({i, rays[i], {}}), open_.back().last.instance = no_instance;
    for (uint32_t layers = surfaces_in_round; !open_.empty();) {
      const bool advanced = step(layers, met, round);
      if (!advanced && layers == most_surfaces_in_round) return;  // more coplanar surfaces than can be distinguished
      layers = advanced ? surfaces_in_round : most_surfaces_in_round;
    }
  }

  // Returns whether any ray advanced. Rays without further surfaces are dropped.
  template <typename Met, typename Round>
  bool step(uint32_t layers, const Met& met, const Round& round) {
    rays_.clear();
    for (const OpenRay& open : open_) rays_.push_back(open.ray);
    hits_.resize(rays_.size() * layers);
    counts_.assign(rays_.size(), 0);
    round(layers);
    bool advanced = false;
    size_t kept = 0;
    for (size_t i = 0; i < open_.size(); ++i) {
      OpenRay open = open_[i];
      const Taken taken = take({&hits_[i * layers], counts_[i]}, open, met);
      advanced |= taken.any;
      if (taken.goes_on && counts_[i] == layers) open_[kept++] = open;
    }
    advanced |= kept < open_.size();
    open_.resize(kept);
    return advanced;
  }

  template <typename Met>
  Taken take(std::span<const Hit> hits, OpenRay& open, const Met& met) const {
    Taken taken{false, true};
    for (const Hit& hit : hits) {
      if (open.last.instance != no_instance && !nearer(open.last, id(open.last), hit, id(hit))) continue;
      open.last = hit;
      taken.any = true;
      taken.goes_on = met(open.index, hit);
      if (!taken.goes_on) return taken;
    }
    if (taken.any)
      open.ray.t_near = std::max(open.ray.t_near, static_cast<float>(open.last.distance * (1.0 - back_step)));
    return taken;
  }

  uint32_t id(const Hit& hit) const { return snapshot_.instances[hit.instance].surface_id; }

  const model::Snapshot& snapshot_;
  const Intersector& intersector_;
  const AlphaCone cone_;
  const bool cull_;
  std::vector<OpenRay> open_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> counts_;
};

}  // namespace sideray::rt
