#include "rt/masks/mask_rays.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "elementary/functions.h"

namespace sideray::rt {
namespace {

constexpr float farthest_ray = 1e15f;

void set(float (&to)[3], glm::vec3 v) {
  for (int i = 0; i < 3; ++i) to[i] = v[i];
}

glm::vec3 vector(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

glm::mat3 frame_of(const RayLight& to) {
  return {vector(to.frame[0]), vector(to.frame[1]), vector(to.frame[2])};
}

// Returns the ray from a point, with the inexact test if the point is marked for it.
Ray started(const RayRandom& random, const DepthPoint& p, glm::vec3 origin, glm::vec3 direction, float t_far) {
  Ray ray{origin, p.skip, direction, t_far};
  if (!p.inexact || random.inexact == SIDERAY_INEXACT_RESTPOSE) return ray;
  const float u = unit_float(random_key({random.seed, bias_purpose, random.dimension, uint32_t{p.y} << 16 | p.x}));
  if (random.inexact == SIDERAY_INEXACT_ORIGIN)
    ray.origin += direction * (u * p.bias);
  else
    ray.t_near = std::max(p.skip, u * p.bias);
  return ray;
}

InexactStart inexact_start(const RayRandom& random) {
  const uint32_t key = random_key({random.seed, bias_purpose, random.dimension});
  if (random.inexact == SIDERAY_INEXACT_RESTPOSE) return {starts_as_others, key};
  return {random.inexact == SIDERAY_INEXACT_ORIGIN ? starts_further : skips_near_hits, key};
}

// Sines and cosines are computed one by one by elementary/, because no vector code here has the same bits.
void turn(RaySamples& samples) {
  for (uint32_t block = 0; block < tile_blocks; ++block)
    for (uint32_t bits = samples.wanted[block]; bits != 0; bits &= bits - 1) {
      const uint32_t i = block * block_pixels + static_cast<uint32_t>(std::countr_zero(bits));
      samples.sine[i] = elementary::sin(samples.azimuth[i]);
      samples.cosine[i] = elementary::cos(samples.azimuth[i]);
    }
}

}  // namespace

TileSamples::TileSamples(const RayRandom& random, uint32_t x0, uint32_t y0) {
  for (uint32_t j = 0; j < across; ++j)
    for (uint32_t i = 0; i < across; ++i) {
      const PointSet set(
          random_key({random.seed, random.purpose, random.layer, (y0 / side + j) << 16 | (x0 / side + i)}));
      const uint32_t block = j * across + i;
      keys_.order[block] = set.order_key();
      keys_.x[block] = set.x_key();
      keys_.y[block] = set.y_key();
    }
}

glm::vec2 TileSamples::at(uint32_t x, uint32_t y, uint32_t sample, uint32_t samples) const {
  const uint32_t i = x % DepthPoints::tile_size, j = y % DepthPoints::tile_size;
  const uint32_t block = j / side * across + i / side;
  return PointSet(keys_.order[block], keys_.x[block], keys_.y[block])[(j % side * side + i % side) * samples + sample];
}

// Solves I (1 - (d / range)^4) / d^2 = E for d^2. It ignores the light's cone, which only reduces its reach.
model::Light reaching(const model::Light& light, float least) {
  const auto intensity = static_cast<double>(std::max({light.intensity.x, light.intensity.y, light.intensity.z}));
  if (!(least > 0.0f) || light.type == SIDERAY_LIGHT_DIRECTIONAL || !(intensity > 0.0)) return light;
  const double irradiance = glm::pi<double>() * double{least}, range = double{light.range};
  const double fading = light.range > 0.0f ? 2.0 * intensity / (range * range) : 0.0;
  model::Light shorter = light;
  shorter.range = static_cast<float>(std::sqrt(2.0 * intensity / (irradiance + elementary::hypot(irradiance, fading))));
  return shorter;
}

RayLight rays_to(const model::Light& light) {
  RayLight to{};
  to.t_far = farthest_ray;
  to.count = 1;
  to.radius = light.radius;
  to.range = light.range;
  to.cos_outer = light.cos_outer;
  set(to.position, light.position);
  set(to.direction, light.direction);
  if (light.type != SIDERAY_LIGHT_DIRECTIONAL) {
    to.kind = light.type == SIDERAY_LIGHT_SPOT ? rays_to_spot : rays_to_point;
    to.samples = light.radius > 0.0f;
    return to;
  }
  to.kind = rays_to_directional;
  to.samples = light.angular_radius > 0.0f;
  to.aperture = cone_aperture(light.angular_radius);
  const glm::mat3 frame = frame_about(-light.direction);
  for (int i = 0; i < 3; ++i) set(to.frame[i], frame[i]);
  set(to.position, frame[2]);
  return to;
}

RayLight rays_to_the_sky(float distance, uint32_t count, uint32_t index) {
  RayLight to{};
  to.kind = rays_to_sky;
  to.samples = true;
  to.t_far = std::min(distance, farthest_ray);
  to.count = count;
  to.index = index;
  return to;
}

bool make_ray(const RayLight& to, const RayRandom& random, const TileSamples& samples, const DepthPoint& p, Ray& ray) {
  const glm::vec2 u = to.samples ? samples.at(p.x, p.y, to.index, to.count) : glm::vec2(0.0f);
  if (to.kind == rays_to_sky) {
    ray = started(random, p, p.front, frame_about(p.normal) * sample_cosine(u), to.t_far);
    return true;
  }
  if (to.kind == rays_to_directional) {
    const glm::mat3 frame = frame_of(to);
    const glm::vec3 d = to.samples ? frame * sample_cone(u, to.aperture) : frame[2];
    ray = started(random, p, p.origin(d), d, to.t_far);
    return true;
  }
  const glm::vec3 offset = vector(to.position) - p.front;
  const float distance = glm::length(offset);
  if (!(distance > to.radius) || (to.range > 0.0f && distance > to.range)) return false;
  const glm::vec3 axis = offset / distance;
  if (to.kind == rays_to_spot && -glm::dot(axis, vector(to.direction)) < to.cos_outer) return false;
  glm::vec3 d = axis;
  float reach = distance;
  if (to.samples) {
    const glm::vec3 sample = sample_cone(u, sphere_aperture(to.radius, distance));
    d = frame_about(axis) * sample;
    reach = distance_to_sphere(to.radius, distance, 1.0f - sample.z);
  }
  ray = started(random, p, p.origin(d), d, reach * (1.0f - 0x1p-20f));
  return true;
}

void TileRays::make(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& tile) {
  kernels_->samples(to, samples.keys(), tile, samples_);
  if (to.samples) turn(samples_);
  drawn_ = false;
  make_sampled(to, random, tile);
}

void TileRays::make(const RayLight& to, const SkyDirections& sky, const RayRandom& random, const TileSamples& samples,
                    const PointTile& tile) {
  RayLight light = to;
  light.kind = rays_to_drawn;
  kernels_->samples(light, samples.keys(), tile, samples_);
  draw(sky, tile);
  drawn_ = true;
  make_sampled(light, random, tile);
}

void TileRays::draw(const SkyDirections& sky, const PointTile& tile) {
  for (uint32_t block = 0; block < tile_blocks; ++block)
    for (uint32_t bits = samples_.wanted[block]; bits != 0; bits &= bits - 1) {
      const uint32_t i = block * block_pixels + static_cast<uint32_t>(std::countr_zero(bits));
      const glm::vec3 normal(tile.normal[0][i], tile.normal[1][i], tile.normal[2][i]);
      const SkyDirections::Draw drawn =
          sky.draw(SkyDirections::facing(normal), normal,
                   {samples_.u[i], std::min(samples_.azimuth[i] * glm::one_over_two_pi<float>(), 1.0f)});
      for (int k = 0; k < 3; ++k) samples_.drawn[k][i] = drawn.direction[k];
      // A ray below the surface would hit that surface at once, and the filter would take it for a contact.
      if (drawn.weight == 0.0f) samples_.wanted[block] &= static_cast<uint16_t>(~(1u << (i % block_pixels)));
      weight_[i] = drawn.weight;
    }
}

void TileRays::make_sampled(const RayLight& to, const RayRandom& random, const PointTile& tile) {
  const RayArrays arrays{
      {origin_[0], origin_[1], origin_[2]}, {direction_[0], direction_[1], direction_[2]}, t_near_, t_far_, pixel_};
  count_ = kernels_->rays(to, inexact_start(random), samples_, tile, arrays);
}

void TileRays::push_back(const Ray& ray, uint32_t pixel) {
  for (int i = 0; i < 3; ++i) {
    origin_[i][count_] = ray.origin[i];
    direction_[i][count_] = ray.direction[i];
  }
  t_near_[count_] = ray.t_near;
  t_far_[count_] = ray.t_far;
  pixel_[count_++] = static_cast<uint16_t>(pixel);
}

void TileRays::move(uint32_t from, uint32_t to) {
  for (int i = 0; i < 3; ++i) {
    origin_[i][to] = origin_[i][from];
    direction_[i][to] = direction_[i][from];
  }
  t_near_[to] = t_near_[from];
  t_far_[to] = t_far_[from];
  pixel_[to] = pixel_[from];
}

RayColumns TileRays::columns() const {
  return {{origin_[0], origin_[1], origin_[2]}, {direction_[0], direction_[1], direction_[2]}, t_near_, t_far_, count_};
}

}  // namespace sideray::rt
