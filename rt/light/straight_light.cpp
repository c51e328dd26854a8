#include "rt/light/straight_light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/largest.h"

namespace sideray::rt {
namespace {

constexpr float most_scattered = 0.98f;
// Surfaces up to this many offsets apart along the normal count as being at one place.
constexpr float skin_offsets = 2.0f, least_cosine = 1e-3f, rounding = 0x1p-20f;

// Returns the media at the ray's start: those that it leaves without having entered, the outermost left last.
MediumStack media_before(std::span<const StraightSurface> met) {
  MediumStack entered, begun;
  std::array<uint32_t, MediumStack::capacity> left;
  uint32_t count = 0;
  for (const StraightSurface& s : met) {
    const uint32_t instance = s.hit.instance;
    if (!s.solid) continue;
    if (s.hit.front)
      entered.push(instance);
    else if (entered.contains(instance))
      entered.remove(instance);
    else if (count < left.size())
      left[count++] = instance;
  }
  while (count > 0) begun.push(left[--count]);
  return begun;
}

// Returns how much of a lamp's light the solid or shell around it, where the ray ends, reflects from wall to wall: a
// frosted bulb sends that out as if it came from the lamp. 0 if the ray ends in nothing that it enters. Within a shell
// nothing absorbs but the walls, so all reflections form a geometric series.
glm::vec3 scattered_around_end(std::span<const StraightSurface> met) {
  for (size_t i = met.size(); i-- > 0;) {
    const StraightSurface& s = met[i];
    const auto leaves = [&](const StraightSurface& later) { return later.hit.instance == s.hit.instance && !later.hit.front; };
    if (!(s.solid || s.shell) || !s.hit.front) continue;
    if (std::any_of(met.begin() + static_cast<ptrdiff_t>(i) + 1, met.end(), leaves)) continue;
    return s.solid ? s.scattered : s.scattered / (1.0f - glm::min(s.scattered, most_scattered));
  }
  return glm::vec3(0.0f);
}

glm::vec3 faded(glm::vec3 absorption, float distance) {
  glm::vec3 through(1.0f);
  for (int c = 0; c < 3; ++c)
    if (absorption[c] > 0.0f) through[c] = shading::sr_faded(absorption[c] * std::max(distance, 0.0f));
  return through;
}

// Returns a solid surface's transmittance between two media.
glm::vec3 through_interface(const StraightSurface& s, const Crossing& crossing) {
  if (crossing.ior_from == 1.0f || crossing.ior_to == 1.0f || s.cover == 0.0f) return s.through;
  const float reflected = dielectric_reflectance(s.cosine, crossing.ior_from, crossing.ior_to);
  const glm::vec3 passed = glm::max(1.0f - s.edge * reflected, glm::vec3(0.0f));
  return (1.0f - s.cover) + s.cover * s.inner * passed;
}

// Returns whether one solid ends where another begins. The latter then comes first, because there is no gap between
// them.
bool ends_where_next_begins(const StraightSurface& s, const StraightSurface& next) {
  return s.solid && next.solid && !s.hit.front && next.hit.front &&
         next.hit.distance <= s.hit.distance + static_cast<double>(s.skin);
}

// Returns the unit shading normal of the front face at a hit, or 0 if there is none.
glm::vec3 smooth_normal(const InstanceRecord& in, const Hit& hit) {
  const uint32_t* t = in.triangles + size_t{3} * hit.primitive;
  const float weights[3] = {1.0f - hit.u - hit.v, hit.u, hit.v};
  glm::vec3 object(0.0f), normal(0.0f);
  for (int k = 0; k < 3; ++k) {
    const float* n = in.normals + size_t{3} * t[k];
    object += glm::vec3(n[0], n[1], n[2]) * weights[k];
  }
  for (int c = 0; c < 3; ++c)
    normal += glm::vec3(in.normal_columns[c][0], in.normal_columns[c][1], in.normal_columns[c][2]) * object[c];
  const float squared = glm::dot(normal, normal);
  return squared > 1e-24f && std::isfinite(squared) ? normal * (1.0f / std::sqrt(squared)) : glm::vec3(0.0f);
}

float largest_coordinate(const model::Bounds& bounds) {
  return largest(glm::max(glm::abs(bounds.minimum), glm::abs(bounds.maximum)));
}

// Marks rays that come near a box by 1. Without branches, so that it becomes vector code.
void find_near(const model::Bounds& bounds, const RayColumns& rays, uint8_t* near) {
  // The margin covers rounding, and 0 times infinity never occurs.
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

StraightSurface straight_surface(const RefractionScene& media, const SurfacePoint& p) {
  const float cosine = std::min(std::abs(glm::dot(p.surface.normal, p.to_eye)), 1.0f);
  const float across = std::max(std::abs(glm::dot(p.geometric_normal, p.to_eye)), least_cosine);
  const bool multiplies = p.blend == SIDERAY_BLEND_MULTIPLY;
  return {p.hit, is_solid(media, p.hit), is_shell(media, p.hit), cosine, skin_offsets * p.offset / across, p.blended.through,
          inner_of(p.surface), edge_of(p.surface), multiplies ? 0.0f : p.surface.alpha, scattered_by(p.surface)};
}

glm::vec3 straight_transmittance(const RefractionScene& media, std::span<const StraightSurface> met, float length,
                                 const MediumStack* within) {
  MediumStack inside = within ? *within : media_before(met);
  glm::vec3 left(1.0f);
  float absorbed = 0.0f;
  const auto absorb = [&](float to) {
    if (!inside.empty()) left *= faded(media.medium(inside.top()).absorption, to - absorbed);
    absorbed = to;
  };
  const StraightSurface* waiting = nullptr;  // one that ended where the next one began
  for (size_t i = 0; i < met.size() || waiting; ++i) {
    const StraightSurface* s = waiting ? waiting : &met[i];
    if (waiting) {
      --i;
      waiting = nullptr;
    } else if (i + 1 < met.size() && ends_where_next_begins(*s, met[i + 1])) {
      waiting = s;
      s = &met[++i];
    }
    if (s->solid) {
      MediumStack behind = inside;
      const Crossing crossing = cross(media, s->hit, false, behind);
      absorb(static_cast<float>(s->hit.distance));
      if (crossing.interface) left *= through_interface(*s, crossing);
      inside = behind;
    } else {
      left *= s->through;
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

void StraightLight::follow(std::span<const Ray> rays) {
  through_.assign(rays.size(), glm::vec3(1.0f));
  distance_.assign(rays.size(), INFINITY);
  if (rays.empty()) return;
  meet(rays);
  finish_surfaces();
  uint32_t first = 0;
  for (size_t r = 0; r < rays.size(); first = found_.ends[r++]) {
    const std::span<const StraightSurface> on_ray(met_.data() + first, found_.ends[r] - first);
    if (on_ray.empty()) continue;
    through_[r] = straight_transmittance(*scene_->glass, on_ray, rays[r].t_far);
    if (rays[r].t_far < 0.5f * farthest) through_[r] *= 1.0f + scattered_around_end(on_ray);
    if (through_[r] != glm::vec3(1.0f)) distance_[r] = static_cast<float>(on_ray.front().hit.distance);
  }
}

// Makes the surfaces with textures or vertex colours.
void StraightLight::finish_surfaces() {
  const ShadeKernels& kernels = shade_kernels(intersector_->isa().c_str());
  for (const Textured* textured : {&solids_, &others_}) {
    points_.resize(textured->places.size());
    make_surfaces(textured == &solids_ ? scene_->glass->surfaces : *scene_, kernels, textured->places, points_.data());
    for (size_t i = 0; i < points_.size(); ++i)
      met_[textured->met[i]] = straight_surface(*scene_->glass, points_[i]);
  }
}

// Finds the surfaces on the rays.
void StraightLight::meet(std::span<const Ray> rays) {
  traversals += rays.size();
  intersector_->all_layers(LayerSet::tints_light, rays, found_);
  for (Textured* textured : {&solids_, &others_}) {
    textured->places.clear();
    textured->met.clear();
  }
  met_.clear();
  uint32_t first = 0;
  for (size_t r = 0; r < rays.size(); first = found_.ends[r++])
    take(rays[r], {found_.hits.data() + first, found_.ends[r] - first});
}

void StraightLight::take(const Ray& ray, std::span<const Hit> hits) {
  const RefractionScene& glass = *scene_->glass;
  for (const Hit& hit : hits) {
    const model::Instance& instance = scene_->snapshot->instances[hit.instance];
    const bool solid = is_solid(glass, hit);
    const InstanceRecord& record = scene_->records.instances[hit.instance];
    const PlainGlass& plain = (solid ? glass.plain_solid : glass.plain_other)[instance.material];
    const glm::vec3 normal = plain.through.empty() || record.colors ? glm::vec3(0.0f) : smooth_normal(record, hit);
    if (normal == glm::vec3(0.0f)) {
      Textured& textured = solid ? solids_ : others_;
      textured.places.push_back({&hit, &ray, Cone{}});
      textured.met.push_back(static_cast<uint32_t>(met_.size()));
      met_.emplace_back();
      continue;
    }
    // A perturbed normal may point beyond the horizon; the cosine is then 0.
    const float cosine = std::clamp(glm::dot(hit.front ? -normal : normal, ray.direction), 0.0f, 1.0f);
    const float skin = skin_offsets * rounding * largest_coordinate(instance.bounds) / std::max(cosine, least_cosine);
    // Assigned in place, since copying what was just written in smaller parts stalls the processor.
    StraightSurface& s = met_.emplace_back();
    s.hit = hit;
    s.solid = solid;
    s.shell = instance.shell;
    s.cosine = cosine;
    s.skin = skin;
    s.through = plain.at(cosine);
    s.inner = plain.inner;
    s.edge = plain.edge;
    s.cover = plain.cover;
    s.scattered = plain.scattered;
  }
}

}  // namespace sideray::rt
