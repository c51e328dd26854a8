#include "rt/shading/straight_light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/largest.h"

namespace sideray::rt {
namespace {

constexpr uint32_t met_at_first = 4, most_met = 64;
// Surfaces this many offsets apart, along the normal, count as being at one place.
constexpr float skin_offsets = 2.0f, least_cosine = 1e-3f;

bool is_solid(const RefractionScene& media, const Hit& hit) {
  return media.surfaces.snapshot->instances[hit.instance].solid && media.medium(hit.instance).volume;
}

// Returns the media that the ray begins in: those that it leaves without having entered them, the outermost left last.
MediumStack media_before(const RefractionScene& media, std::span<const SurfacePoint* const> met) {
  MediumStack entered, begun;
  std::array<uint32_t, MediumStack::capacity> left;
  uint32_t count = 0;
  for (const SurfacePoint* p : met) {
    const uint32_t instance = p->hit.instance;
    if (!is_solid(media, p->hit)) continue;
    if (p->hit.front)
      entered.push(instance);
    else if (entered.contains(instance))
      entered.remove(instance);
    else if (count < left.size())
      left[count++] = instance;
  }
  while (count > 0) begun.push(left[--count]);
  return begun;
}

glm::vec3 faded(glm::vec3 absorption, float distance) {
  glm::vec3 through(1.0f);
  for (int c = 0; c < 3; ++c)
    if (absorption[c] > 0.0f) through[c] = shading::sr_faded(absorption[c] * std::max(distance, 0.0f));
  return through;
}

// Returns what the surface of a solid lets through where the ray goes from one medium to another.
glm::vec3 through_interface(const SurfacePoint& p, const Crossing& crossing) {
  if (crossing.ior_from == 1.0f || crossing.ior_to == 1.0f) return p.blended.through;
  shading::SrSurface between = p.surface;
  const float cosine = std::min(std::abs(glm::dot(between.normal, p.to_eye)), 1.0f);
  set_reflectance(crossing, cosine, between);
  return shading::sr_blend(between, p.to_eye, p.blend).through;
}

// Where one solid ends and another begins at the same place, the latter comes first: there is no gap between them.
bool ends_where_next_begins(const RefractionScene& media, const SurfacePoint& p, const SurfacePoint& next) {
  if (p.hit.front || !next.hit.front || !is_solid(media, p.hit) || !is_solid(media, next.hit)) return false;
  const float cosine = std::max(std::abs(glm::dot(p.geometric_normal, p.to_eye)), least_cosine);
  return next.hit.distance <= p.hit.distance + static_cast<double>(skin_offsets * p.offset / cosine);
}

// Says which rays come near a box: 1, else 0. Without branches, so that it becomes vectors.
void find_near(const model::Bounds& bounds, const RayColumns& rays, uint8_t* near) {
  // Beyond rounding, and 0 times infinity never occurs.
  constexpr float share = 1e-5f, least_direction = 1e-20f;
  const glm::vec3 corner = glm::max(glm::abs(bounds.minimum), glm::abs(bounds.maximum));
  for (size_t r = 0; r < rays.count; ++r) {
    float from = rays.t_near[r], to = rays.t_far[r];
    for (int c = 0; c < 3; ++c) {
      const float origin = rays.origin[c][r], direction = rays.direction[c][r];
      const float margin = share * (corner[c] + std::abs(origin));
      const float size = std::abs(direction) > least_direction ? std::abs(direction) : least_direction;
      const float inverse = 1.0f / std::copysign(size, direction);
      const float a = (bounds.minimum[c] - margin - origin) * inverse, b = (bounds.maximum[c] + margin - origin) * inverse;
      const float low = a < b ? a : b, high = a < b ? b : a;
      from = low > from ? low : from;
      to = high < to ? high : to;
    }
    near[r] = from <= to ? 1 : 0;
  }
}

}  // namespace

glm::vec3 straight_transmittance(const RefractionScene& media, std::span<const SurfacePoint* const> met, float length,
                                 const MediumStack* within) {
  MediumStack inside = within ? *within : media_before(media, met);
  glm::vec3 left(1.0f);
  float absorbed = 0.0f;
  const auto absorb = [&](float to) {
    if (!inside.empty()) left *= faded(media.medium(inside.top()).absorption, to - absorbed);
    absorbed = to;
  };
  std::array<const SurfacePoint*, most_met> order;
  const size_t count = std::min<size_t>(met.size(), most_met);
  std::copy_n(met.begin(), count, order.begin());
  for (size_t i = 0; i < count; ++i) {
    if (i + 1 < count && ends_where_next_begins(media, *order[i], *order[i + 1])) std::swap(order[i], order[i + 1]);
    const SurfacePoint& p = *order[i];
    if (is_solid(media, p.hit)) {
      MediumStack behind = inside;
      const Crossing crossing = cross(media, p.hit, false, behind);
      absorb(static_cast<float>(p.hit.distance));
      if (crossing.interface) left *= through_interface(p, crossing);
      inside = behind;
    } else {
      left *= p.blended.through;
    }
    if (!(largest(left) > least_straight_light)) return glm::vec3(0.0f);
  }
  if (length < 0.5f * farthest) absorb(length);
  left = glm::clamp(left, glm::vec3(0.0f), glm::vec3(1.0f));
  return largest(left) > least_straight_light ? left : glm::vec3(0.0f);
}

void StraightLight::begin(const ShadingScene& scene, const Intersector& intersector) {
  scene_ = &scene;
  intersector_ = &intersector;
  traversals = 0;
}

void StraightLight::choose(const RayColumns& from, const uint8_t* blocked, std::vector<Ray>& rays,
                           std::vector<uint32_t>& numbers) {
  near_.resize(from.count);
  find_near(scene_->glass->tinting, from, near_.data());
  for (size_t r = 0; r < from.count; ++r) {
    if (!near_[r] || blocked[r]) continue;
    rays.push_back(from[r]);
    numbers.push_back(static_cast<uint32_t>(r));
  }
}

void StraightLight::follow(std::span<const Ray> rays, bool coherent) {
  through_.assign(rays.size(), glm::vec3(1.0f));
  distance_.assign(rays.size(), INFINITY);
  if (rays.empty()) return;
  meet(rays, coherent);
  const ShadeKernels& kernels = shade_kernels(intersector_->isa().c_str());
  solid_points_.resize(solid_places_.size());
  other_points_.resize(other_places_.size());
  make_surfaces(scene_->glass->surfaces, kernels, solid_places_, solid_points_.data());
  make_surfaces(*scene_, kernels, other_places_, other_points_.data());
  size_t next = 0;
  for (size_t r = 0; r < rays.size(); ++r) {
    on_ray_.clear();
    for (; next < met_end_[r]; ++next)
      on_ray_.push_back(met_[next].solid ? &solid_points_[met_[next].point] : &other_points_[met_[next].point]);
    if (on_ray_.empty()) continue;
    const glm::vec3 through = straight_transmittance(*scene_->glass, on_ray_, rays[r].t_far);
    through_[r] = through;
    if (through != glm::vec3(1.0f)) distance_[r] = static_cast<float>(on_ray_.front()->hit.distance);
  }
}

// Finds the surfaces on the rays: a few, and all there are of the rays that meet as many.
void StraightLight::meet(std::span<const Ray> rays, bool coherent) {
  traversals += rays.size();
  hits_.resize(rays.size() * met_at_first);
  counts_.resize(rays.size());
  intersector_->nearest_layers(LayerSet::tints_light, rays, met_at_first, coherent, hits_.data(), counts_.data(), {},
                               false);
  deep_rays_.clear();
  deep_of_.assign(rays.size(), 0);
  for (size_t r = 0; r < rays.size(); ++r) {
    if (counts_[r] < met_at_first) continue;
    deep_of_[r] = static_cast<uint32_t>(deep_rays_.size());
    deep_rays_.push_back(rays[r]);
  }
  if (!deep_rays_.empty()) {
    traversals += deep_rays_.size();
    deep_hits_.resize(deep_rays_.size() * most_met);
    deep_counts_.resize(deep_rays_.size());
    intersector_->nearest_layers(LayerSet::tints_light, deep_rays_, most_met, coherent, deep_hits_.data(),
                                 deep_counts_.data(), {}, false);
  }
  solid_places_.clear();
  other_places_.clear();
  met_.clear();
  met_end_.clear();
  for (size_t r = 0; r < rays.size(); ++r) {
    const size_t deep = deep_of_[r];
    if (counts_[r] < met_at_first)
      take(rays[r], {&hits_[r * met_at_first], counts_[r]});
    else
      take(rays[r], {&deep_hits_[deep * most_met], deep_counts_[deep]});
    met_end_.push_back(static_cast<uint32_t>(met_.size()));
  }
}

void StraightLight::take(const Ray& ray, std::span<const Hit> hits) {
  for (const Hit& hit : hits) {
    const bool solid = is_solid(*scene_->glass, hit);
    std::vector<HitPlace>& places = solid ? solid_places_ : other_places_;
    met_.push_back({static_cast<uint32_t>(places.size()), solid});
    places.push_back({&hit, &ray, Cone{}});
  }
}

}  // namespace sideray::rt
