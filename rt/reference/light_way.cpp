#include "rt/reference/light_way.h"

#include <algorithm>
#include <cmath>

#include "rt/embree/recompute.h"

namespace sideray::rt {
namespace {

constexpr float farthest = 1e30f;
constexpr uint32_t most_layers_at_once = 64;
// These are those of rt/refraction/refraction_tracer.cpp, where each says what it is for.
constexpr double step_back_share = 1e-6;
constexpr float least_rise = 1e-3f;
constexpr float skin_in_offsets = 2.0f;
constexpr float before_opaque = 0x1p-21f;

Hit nothing() {
  Hit hit{};
  hit.instance = no_instance;
  return hit;
}

}  // namespace

LightWay::LightWay(glm::vec3 origin, glm::vec3 direction, float length, Cone footprint, const MediumStack& around)
    : ray{origin, 0.0f, direction, length}, cone(footprint), media(around), opaque(nothing()), last(nothing()) {}

void LightWays::begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction) {
  surfaces_ = refraction ? &refraction->surfaces : &scene;
  intersector_ = &intersector;
  refraction_ = refraction;
  has_translucent_ = intersector.has_translucent(LayerSet::with_sprites);
  traversals = 0;
}

void LightWays::find_opaque(std::span<LightWay* const> ways) {
  rays_.clear();
  group_.clear();
  for (LightWay* way : ways) {
    if (!way->fresh) continue;
    way->fresh = false;
    group_.push_back(way);
    rays_.push_back(way->ray);
    rays_.back().t_near = 0.0f;  // from before a surface that was crossed: an opaque one may lie on it
  }
  if (rays_.empty()) return;
  hits_.resize(rays_.size());
  intersector_->nearest_opaque(rays_, directions_agree(rays_), hits_.data());
  traversals += rays_.size();
  for (size_t i = 0; i < group_.size(); ++i) {
    group_[i]->opaque = hits_[i];
    if (hits_[i].instance != no_instance)
      group_[i]->ray.t_far = static_cast<float>(hits_[i].distance) * (1.0f - before_opaque);
  }
}

void LightWays::find_translucent(std::span<LightWay* const> ways) {
  if (!has_translucent_) {
    for (LightWay* way : ways) way->complete = true;
    return;
  }
  for (const uint32_t layers : {LightWay::most_pending, most_layers_at_once}) {
    group_.clear();
    rays_.clear();
    for (LightWay* way : ways) {
      if (way->pending_count > 0 || way->complete || way->deep != (layers == most_layers_at_once)) continue;
      group_.push_back(way);
      rays_.push_back(way->ray);
    }
    if (group_.empty()) continue;
    hits_.resize(rays_.size() * layers);
    counts_.resize(rays_.size());
    // Backs are found too: whether one is seen depends on the media there (is_there).
    intersector_->nearest_layers(LayerSet::with_sprites, rays_, layers, directions_agree(rays_), hits_.data(),
                                 counts_.data(), {}, false);
    traversals += rays_.size();
    for (size_t i = 0; i < group_.size(); ++i) take_hits(*group_[i], &hits_[i * layers], counts_[i], layers);
  }
}

void LightWays::take_hits(LightWay& way, const Hit* hits, uint32_t count, uint32_t layers) const {
  const std::vector<model::Instance>& instances = surfaces_->snapshot->instances;
  const auto id = [&](const Hit& h) { return instances[h.instance].surface_id; };
  uint32_t taken = 0;
  while (taken < count && way.pending_count < LightWay::most_pending) {
    const Hit& hit = hits[taken++];
    if (way.last.instance != no_instance && !nearer(way.last, id(way.last), hit, id(hit))) continue;
    way.pending[way.pending_count++] = hit;
  }
  way.complete = taken == count && (count < layers || (way.deep && way.pending_count == 0));
  way.deep = way.pending_count == 0;  // more surfaces are at one place than a round finds
  if (way.pending_count == 0) return;
  way.last = way.pending[way.pending_count - 1];
  way.ray.t_near = std::max(way.ray.t_near, static_cast<float>(way.last.distance * (1.0 - step_back_share)));
}

// Rays that are not bent see no backs of materials that are not double sided, as the rasterizer's eye does not.
bool LightWays::is_there(const LightWay& way, const Hit& hit) const {
  const model::Instance& instance = surfaces_->snapshot->instances[hit.instance];
  if (instance.sprites == 0 && !(instance.visibility & SIDERAY_VISIBLE_REFLECTION)) return false;
  if (hit.front || !surfaces_->snapshot->materials[instance.material].cull_back) return true;
  return (way.bent || !way.media.empty()) && is_volume(hit);
}

bool LightWays::exits(const Hit& hit) const {
  return is_volume(hit) && (!surfaces_->snapshot->instances[hit.instance].solid || !hit.front);
}

// Takes the next hit. Among surfaces at one place those that are entered come first, as in RefractionTracer::next_hit.
Hit LightWays::take(LightWay& way) const {
  uint32_t chosen = 0;
  if (way.pending_count > 1 && exits(way.pending[0])) {
    const SurfacePoint first = surface_point(*surfaces_, way.pending[0], way.ray, way.cone);
    const float cosine = std::max(glm::dot(first.geometric_normal, first.to_eye), least_rise);
    const double limit = way.pending[0].distance + static_cast<double>(skin_in_offsets * first.offset / cosine);
    for (uint32_t k = 1; k < way.pending_count && way.pending[k].distance <= limit && chosen == 0; ++k)
      if (!exits(way.pending[k])) chosen = k;
  }
  const Hit hit = way.pending[chosen];
  std::copy(way.pending + chosen + 1, way.pending + way.pending_count, way.pending + chosen);
  --way.pending_count;
  return hit;
}

bool LightWays::next(LightWay& way, WayEvent& event) const {
  while (way.pending_count > 0) {
    const Hit hit = take(way);
    if (!is_there(way, hit)) continue;
    const bool volume = is_volume(hit);
    event.crossing = {true, 1.0f, 1.0f, no_instance, false};
    event.behind = way.media;
    if (volume) event.crossing = cross(*refraction_, hit, false, event.behind, way.light);
    if (!event.crossing.interface) {
      way.media = event.behind;
      continue;
    }
    const auto distance = static_cast<float>(hit.distance);
    event.arriving = arriving(way, distance);
    way.absorbed = distance;
    event.point = surface_point(*surfaces_, hit, way.ray, way.cone);
    event.passage = Passage::straight;
    const bool bends = volume && (event.crossing.ior_from != event.crossing.ior_to || event.crossing.disperses);
    if (volume) {
      const Bend bent = bend(event.point.to_eye, facing_normal(event.point), event.crossing.ior_from, event.crossing.ior_to);
      event.direction = bent.direction;
      if (bent.total && !event.crossing.disperses) {
        event.passage = Passage::mirrored;
        return true;
      }
      set_reflectance(event.crossing, bent.cosine, event.point.surface);
      event.point.blended = shading::sr_blend(event.point.surface, event.point.to_eye, event.point.blend);
      if (bends) event.passage = Passage::refracted;
    }
    if (refraction_ && (bends || !volume) && is_scattered(event.point)) event.passage = Passage::scattered;
    return true;
  }
  return false;
}

void LightWays::disperse(LightWay& way, WayEvent& event, Light light) const {
  way.light = light;
  event.behind = way.media;
  event.crossing = cross(*refraction_, event.point.hit, false, event.behind, light);
  const Bend bent = bend(event.point.to_eye, facing_normal(event.point), event.crossing.ior_from, event.crossing.ior_to);
  event.direction = bent.direction;
  event.passage = bent.total ? Passage::mirrored : Passage::refracted;
}

glm::vec3 LightWays::arriving(const LightWay& way, float distance) const {
  return refraction_ ? refraction_->transmittance(way.media, distance - way.absorbed) : glm::vec3(1.0f);
}

// The new ray starts at a point on the near side of the surface, for an opaque surface may lie on it; translucent ones count
// from beyond it, as in RefractionTracer::redirect.
void LightWays::redirect(LightWay& way, const WayEvent& event, glm::vec3 direction) const {
  const SurfacePoint& point = event.point;
  const bool transmitted = event.passage != Passage::mirrored;
  const glm::vec3 side = transmitted ? -point.geometric_normal : point.geometric_normal;
  const float elevation = glm::dot(direction, side);
  if (elevation < least_rise) direction = glm::normalize(direction + side * (least_rise - elevation));
  const float skin = skin_in_offsets * point.offset;
  const double limit = static_cast<double>(
      way.absorbed + skin / std::max(glm::dot(point.geometric_normal, point.to_eye), least_rise));
  LightWay onward(point.position + side * (transmitted ? -skin : skin), direction, farthest, point.cone,
                  transmitted ? event.behind : way.media);
  onward.ray.t_near = transmitted ? 2.0f * skin / std::max(elevation, least_rise) : 0.0f;
  onward.light = way.light;
  onward.bent = true;
  // Surfaces at the same place are still to be crossed, and those alone.
  for (uint32_t k = 0; transmitted && k < way.pending_count && way.pending[k].distance <= limit; ++k) {
    onward.pending[onward.pending_count] = way.pending[k];
    onward.pending[onward.pending_count++].distance = 0.0;
  }
  way = onward;
}

MediumStack LightWays::behind(const SurfacePoint& point, const MediumStack& before) const {
  MediumStack media = before;
  if (point.hit.instance != no_instance && is_volume(point.hit)) cross(*refraction_, point.hit, false, media);
  return media;
}

}  // namespace sideray::rt
