#include "rt/reference/beams.h"

#include <algorithm>

#include "rt/base/largest.h"
#include "rt/refraction/refraction.h"

namespace sideray::rt {

void Beams::begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction) {
  scene_ = &scene;
  intersector_ = &intersector;
  refraction_ = refraction;
  has_translucent_ = intersector.has_translucent(LayerSet::with_sprites);
  traversals = 0;
}

// Keeps only beams without an opaque occluder. The environment is occluded by the surfaces that paths hit, so that both
// sampling strategies agree.
void Beams::find_free(std::vector<Beam>& beams, BeamTarget target) {
  rays_.clear();
  for (const Beam& beam : beams) rays_.push_back(beam.ray);
  blocked_.resize(rays_.size());
  intersector_->occluded(rays_, directions_agree(rays_), blocked_.data(),
                         target == BeamTarget::lamp ? OpaqueSet::casts_shadow : OpaqueSet::visible_in_reflection);
  traversals += rays_.size();
  size_t left = 0;
  for (size_t i = 0; i < beams.size(); ++i)
    if (!blocked_[i]) beams[left++] = beams[i];
  beams.erase(beams.begin() + static_cast<std::ptrdiff_t>(left), beams.end());
}

// Attenuates each beam by translucent surfaces and media on its way.
void Beams::dim(std::vector<Beam>& beams, BeamTarget target) {
  rays_.clear();
  for (const Beam& beam : beams) rays_.push_back(beam.ray);
  if (rays_.empty()) return;
  const auto find = [&](uint32_t layers, std::vector<Ray>& rays, std::vector<Hit>& hits, std::vector<uint32_t>& counts) {
    hits.resize(rays.size() * layers);
    counts.resize(rays.size());
    intersector_->nearest_layers(LayerSet::with_sprites, rays,
                                 {.layers = layers, .coherent = directions_agree(rays), .cull = false}, hits.data(),
                                 counts.data());
    traversals += rays.size();
  };
  find(most_at_first, rays_, hits_, counts_);
  deep_rays_.clear();
  for (size_t i = 0; i < beams.size(); ++i)
    if (counts_[i] == most_at_first) deep_rays_.push_back(rays_[i]);
  if (!deep_rays_.empty()) find(most_met, deep_rays_, deep_hits_, deep_counts_);
  size_t deep = 0;
  for (size_t i = 0; i < beams.size(); ++i) {
    if (counts_[i] < most_at_first) {
      dim(beams[i], target, {&hits_[i * most_at_first], counts_[i]});
    } else {
      dim(beams[i], target, {&deep_hits_[deep * most_met], deep_counts_[deep]});
      ++deep;
    }
  }
}

void Beams::dim(Beam& beam, BeamTarget target, std::span<const Hit> hits) {
  if (hits.empty() && beam.media.empty()) return;
  met_.clear();
  bool bends = false;
  MediumStack media = beam.media;
  for (const Hit& hit : hits) {
    if (!is_there(target, media, hit)) continue;
    bool scatters = false;
    met_.push_back(surface(beam, hit, scatters));
    // If one solid ends where another begins, there is no gap between them.
    const size_t last = met_.size() - 1;
    if (last > 0 && met_[last].solid && hit.front && met_[last - 1].solid && !met_[last - 1].hit.front &&
        hit.distance <= met_[last - 1].hit.distance + static_cast<double>(met_[last - 1].skin))
      std::swap(met_[last], met_[last - 1]);
    bends |= scatters;
    if (is_volume(hit)) cross(*refraction_, hit, false, media);
  }
  // A beam is bent where the index changes; media are tracked in the order of crossings.
  media = beam.media;
  for (const StraightSurface& s : met_) {
    if (bends || !is_volume(s.hit)) continue;
    const Crossing crossing = cross(*refraction_, s.hit, false, media);
    bends = crossing.interface && (crossing.ior_from != crossing.ior_to || crossing.disperses);
  }
  // Light that is transmitted straight is added here; paths find the rest.
  if (bends) beam.gain = beam.bent_gain;
  if (!(largest(beam.gain) > 0.0f)) return;
  if (refraction_) {
    beam.gain *= straight_transmittance(*refraction_, met_, beam.ray.t_far, &beam.media);
  } else {
    for (const StraightSurface& s : met_) beam.gain *= s.through;
  }
}

bool Beams::is_there(BeamTarget target, const MediumStack& media, const Hit& hit) const {
  const model::Instance& instance = scene_->snapshot->instances[hit.instance];
  const uint32_t visible = target == BeamTarget::lamp ? SIDERAY_VISIBLE_SHADOW : SIDERAY_VISIBLE_REFLECTION;
  if (instance.sprites == 0 && !(instance.visibility & visible)) return false;
  // Light of lamps passes both sides (docs/adr/0043-back-faces.md).
  if (target == BeamTarget::lamp || hit.front || !scene_->snapshot->materials[instance.material].cull_back) return true;
  return !media.empty() && is_volume(hit);
}

// Sets `scatters` if the surface is a thin wall that scatters light in many directions.
StraightSurface Beams::surface(const Beam& beam, const Hit& hit, bool& scatters) const {
  const bool solid = refraction_ && is_solid(*refraction_, hit);
  const SurfacePoint point = surface_point(solid ? refraction_->surfaces : *scene_, hit, beam.ray, Cone{});
  if (!refraction_) return {hit, false, false, 0.0f, 0.0f, point.blended.through, glm::vec3(0.0f), glm::vec3(0.0f), 0.0f, glm::vec3(0.0f)};
  scatters = !is_volume(hit) && is_scattered(point);
  return straight_surface(*refraction_, point);
}

}  // namespace sideray::rt
