// Finds the surfaces that refracted paths cross next, for many paths at once. It has scratch memory: one object per
// thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/counters.h"
#include "rt/refraction/refracted_path.h"
#include "rt/refraction/refraction_context.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class NextSurfaces {
 public:
  // Says what paths are followed for: their light, which the media absorb, or only the place where they end.
  enum class Purpose : uint8_t { light, ends };

  // Begins a chunk of pixels. `context` and `counters` are kept; `counters` receives the rays.
  void begin(const RefractionContext& context, Purpose purpose, Counters& counters);

  // Makes the surfaces of places, in their order. They stay valid until the next call of this or find().
  SurfacePoint* make(std::span<const HitPlace> places);

  // Sets RefractedPath::next of the active paths: the next surface that counts, or none. That takes a different number
  // of traversals for each, but all paths cross their surface in the same round, so that they can share rays.
  void find(std::span<RefractedPath> paths, std::span<const uint32_t> active);

  // Returns the surface of the path's next hit; null: it was not made.
  SurfacePoint* surface_of(const RefractedPath& path) {
    return path.surface == RefractedPath::not_made ? nullptr : &made_[path.surface];
  }

 private:
  using Search = RefractedPath::Search;

  Search next_search(const RefractedPath& path) const;
  bool wants_end(const RefractedPath& path) const;
  bool absorbs(const RefractedPath& path) const;
  bool leaves(const Hit& hit) const;
  Cone common_cone() const;

  void find_places();
  void find_opaque();
  void find_layers();
  void traverse_group(uint32_t layers, bool cull);
  void make_next();
  void make_from(size_t first, std::span<const HitPlace> places);

  bool settle(RefractedPath& path) const;
  bool find_way_out(RefractedPath& path) const;
  void take_next(RefractedPath& path) const;
  bool counts(RefractedPath& path) const;

  const RefractionContext* context_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  Counters* counters_ = nullptr;
  Purpose purpose_ = Purpose::light;
  std::span<RefractedPath> paths_;
  std::vector<uint32_t> pending_;  // paths whose next surface is not known yet
  // One traversal: its paths, their rays, and what they hit.
  std::vector<uint32_t> group_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> hit_counts_;
  std::vector<double> known_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> made_;  // surfaces of the paths' next hits; never shrinks
  size_t made_count_ = 0;
};

}  // namespace sideray::rt
