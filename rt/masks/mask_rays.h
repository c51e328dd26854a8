// Makes the rays from opaque pixels to lights and sky, for a whole tile or one point. Any thread; TileRays is scratch
// memory of its thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/base/sampling.h"
#include "rt/masks/depth_points.h"
#include "rt/points/point_kernels.h"
#include "rt/textures/sky_directions.h"

namespace sideray::rt {

// Says what the random numbers of some rays depend on, and which inexact test they take.
struct RayRandom {
  uint32_t seed;
  uint32_t purpose;    // of the samples on a light or in the sky
  uint32_t layer;      // of the samples, as `purpose`
  uint32_t dimension;  // of the inexact test
  sideray_inexact inexact;
};

// Makes point sets over each 8x8 block of a tile's pixels, so that neighbours' samples are stratified, which suits
// spatial filters.
class TileSamples {
 public:
  TileSamples(const RayRandom& random, uint32_t x0, uint32_t y0);
  // Returns one of the `samples` of the pixel at (x, y) in the picture.
  glm::vec2 at(uint32_t x, uint32_t y, uint32_t sample, uint32_t samples) const;
  const SampleKeys& keys() const { return keys_; }

 private:
  static constexpr uint32_t side = 8, across = DepthPoints::tile_size / side;
  SampleKeys keys_;
};

inline constexpr uint32_t bias_purpose = 32;  // of the inexact test's random numbers

// Returns the light with its range reduced to where it adds the radiance `least` to a white diffuse surface that faces
// it. If `least` is 0 or the light is directional, returns it unchanged.
model::Light reaching(const model::Light& light, float least);

RayLight rays_to(const model::Light& light);
// Returns ray `index` of a pixel's `count` rays to the sky, which end at `distance`.
RayLight rays_to_the_sky(float distance, uint32_t count, uint32_t index);

// Makes the ray of one point; returns false if the light does not reach it.
bool make_ray(const RayLight& to, const RayRandom& random, const TileSamples& samples, const DepthPoint& point,
              Ray& ray);

// Holds the rays of a tile's pixels.
class TileRays {
 public:
  explicit TileRays(const PointKernels& kernels = point_kernels()) : kernels_(&kernels) {}

  // Makes the rays of all points that the light reaches, block by block.
  void make(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& tile);
  // Does the same for the sky, with directions sampled by its radiance; black parts get none. weight() then holds the
  // sampling weights.
  void make(const RayLight& to, const SkyDirections& sky, const RayRandom& random, const TileSamples& samples,
            const PointTile& tile);
  void clear() { count_ = 0, drawn_ = false; }
  void push_back(const Ray& ray, uint32_t pixel);
  // Keeps the rays for whose index keep(index) is true.
  template <typename Keep>
  void keep(const Keep& keep) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count_; ++i)
      if (keep(i)) move(i, kept++);
    count_ = kept;
  }

  uint32_t size() const { return count_; }
  uint32_t pixel(uint32_t ray) const { return pixel_[ray]; }                         // its index in the tile
  const uint16_t* pixels() const { return pixel_; }
  float weight(uint32_t ray) const { return drawn_ ? weight_[pixel_[ray]] : 1.0f; }  // as SkyDirections::Draw
  RayColumns columns() const;

 private:
  static constexpr uint32_t room = point_tile_pixels + 16;
  void move(uint32_t from, uint32_t to);
  void make_sampled(const RayLight& to, const RayRandom& random, const PointTile& tile);
  void draw(const SkyDirections& sky, const PointTile& tile);

  const PointKernels* kernels_;
  uint32_t count_ = 0;
  alignas(64) float origin_[3][room];
  alignas(64) float direction_[3][room];
  alignas(64) float t_near_[room];
  alignas(64) float t_far_[room];
  uint16_t pixel_[room];
  bool drawn_ = false;
  float weight_[point_tile_pixels];  // of sampled directions, by pixel
  RaySamples samples_;
};

}  // namespace sideray::rt
