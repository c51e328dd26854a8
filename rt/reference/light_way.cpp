#include "rt/reference/light_way.h"

#include <algorithm>
#include <cmath>

#include "rt/embree/recompute.h"

namespace sideray::rt {
namespace {

constexpr uint32_t most_layers_at_once = 64;

Hit nothing() {
  Hit hit{};
  hit.instance = no_instance;
  return hit;
}

}  // namespace

LightWay::LightWay(const Ray& unit, Cone footprint, const MediumStack& around)
    : ray(unit), cone(footprint), media(around), opaque(nothing()) {}

void LightWay::end_at(const Hit& hit) {
  fresh = false;
  opaque = hit;
  if (hit.instance != no_instance) ray.t_far = static_cast<float>(hit.distance) * (1.0f - on_opaque_surface);
}

void LightWays::begin(const ShadingScene& scene, const Intersector& intersector, const RefractionScene* refraction) {
  surfaces_ = refraction ? &refraction->surfaces : &scene;
  intersector_ = &intersector;
  refraction_ = refraction;
  has_translucent_ = intersector.has_translucent(LayerSet::with_sprites);
  traversals = 0;
}

void LightWays::find_opaque(std::span<LightWay* const> ways) {
  for (const bool from_eye : {false, true}) find_opaque(ways, from_eye);
}

void LightWays::find_opaque(std::span<LightWay* const> ways, bool from_eye) {
  rays_.clear();
  group_.clear();
  for (LightWay* way : ways) {
    if (!way->fresh || way->from_eye != from_eye) continue;
    way->fresh = false;
    group_.push_back(way);
    rays_.push_back(way->ray);
    rays_.back().t_near = 0.0f;  // starting in front of the crossed surface, because an opaque one may lie on it
  }
  if (rays_.empty()) return;
  hits_.resize(rays_.size());
  OpaqueSearch search{.coherent = directions_agree(rays_)};
  if (from_eye) search.set = OpaqueSet::all, search.cone = eye_, search.cull = true;
  intersector_->nearest_opaque(rays_, search, hits_.data());
  traversals += rays_.size();
  for (size_t i = 0; i < group_.size(); ++i) group_[i]->end_at(hits_[i]);
}

void LightWays::find_translucent(std::span<LightWay* const> ways) {
  if (!has_translucent_) {
    for (LightWay* way : ways) way->ahead.end();
    return;
  }
  for (const bool from_eye : {false, true})
    for (const uint32_t layers : {SurfacesAhead::most, most_layers_at_once}) find_translucent(ways, from_eye, layers);
}

void LightWays::find_translucent(std::span<LightWay* const> ways, bool from_eye, uint32_t layers) {
  group_.clear();
  rays_.clear();
  for (LightWay* way : ways) {
    const bool is_searched = way->ahead.count == 0 && !way->ahead.complete() && way->from_eye == from_eye;
    if (!is_searched || way->ahead.deep != (layers == most_layers_at_once)) continue;
    group_.push_back(way);
    rays_.push_back(way->ray);
  }
  if (group_.empty()) return;
  hits_.resize(rays_.size() * layers);
  counts_.resize(rays_.size());
  // Includes backs; whether one is visible depends on the media there (is_there).
  intersector_->nearest_layers(
      LayerSet::with_sprites, rays_,
      {.layers = layers, .coherent = directions_agree(rays_), .cone = from_eye ? eye_ : AlphaCone{}, .cull = false},
      hits_.data(), counts_.data());
  traversals += rays_.size();
  const std::vector<model::Instance>& instances = surfaces_->snapshot->instances;
  for (size_t i = 0; i < group_.size(); ++i)
    group_[i]->ahead.take(instances, {&hits_[i * layers], counts_[i]}, layers, group_[i]->ray);
}

// Returns whether the ray sees the hit. Unbent rays do not see backs of materials that are not double sided, as in the
// rasterizer (docs/adr/0043-back-faces.md).
bool LightWays::is_there(const LightWay& way, const Hit& hit) const {
  const model::Instance& instance = surfaces_->snapshot->instances[hit.instance];
  if (!way.from_eye && instance.sprites == 0 && !(instance.visibility & SIDERAY_VISIBLE_REFLECTION)) return false;
  if (hit.front || !surfaces_->snapshot->materials[instance.material].cull_back) return true;
  return (way.bent || !way.media.empty()) && is_volume(hit);
}

bool LightWays::exits(const Hit& hit) const {
  return is_volume(hit) && (!surfaces_->snapshot->instances[hit.instance].solid || !hit.front);
}

Hit LightWays::take(LightWay& way) const {
  SurfacesAhead& ahead = way.ahead;
  if (ahead.count == 1 || !exits(ahead.hits[0])) return ahead.remove(0);
  return ahead.remove(first_entered(ahead, surface_point(*surfaces_, ahead.hits[0], way.ray, way.cone),
                                    [&](const Hit& hit) { return exits(hit); }));
}

bool LightWays::next(LightWay& way, WayEvent& event) const {
  while (way.ahead.count > 0) {
    const Hit hit = take(way);
    if (!is_there(way, hit)) continue;
    const bool volume = is_volume(hit);
    event.crossing = {true, 1.0f, 1.0f, no_instance, false};
    event.behind = way.media;
    if (volume) event.crossing = cross(*refraction_, hit, way.from_eye && !way.crossed, event.behind, way.light);
    if (!event.crossing.interface) {
      way.media = event.behind;
      continue;
    }
    way.crossed = true;
    if (event.crossing.absorber != no_instance) way.media.push(event.crossing.absorber);
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

void LightWays::redirect(LightWay& way, const WayEvent& event, glm::vec3 direction) const {
  const SurfacePoint& point = event.point;
  const bool transmitted = event.passage != Passage::mirrored;
  const OnwardRay anew = onward_ray(point, way.absorbed, direction, transmitted);
  LightWay onward(anew.ray, point.cone, transmitted ? event.behind : way.media);
  onward.light = way.light;
  onward.bent = onward.crossed = true;
  onward.from_eye = way.from_eye;
  if (transmitted) onward.ahead = way.ahead;
  onward.ahead.start_anew(anew.limit);
  way = onward;
}

MediumStack LightWays::behind(const SurfacePoint& point, const MediumStack& before) const {
  MediumStack media = before;
  if (point.hit.instance != no_instance && is_volume(point.hit)) cross(*refraction_, point.hit, false, media);
  return media;
}

}  // namespace sideray::rt
