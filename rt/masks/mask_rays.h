// Makes the rays by which opaque pixels see lights and sky: of a whole tile at a time, or one. Any thread; TileRays is
// scratch memory of its thread.
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

// Holds what a kind of rays draws its random numbers from, and how rays of pixels that take the inexact test start.
struct RayRandom {
  uint32_t seed;
  uint32_t purpose;    // of the points on a light, or in the sky
  uint32_t layer;      // likewise
  uint32_t dimension;  // of the inexact test
  sideray_inexact inexact;
};

// Makes point sets over each 8x8 block of a tile's pixels, so that neighbours' samples are stratified: what a spatial
// filter needs.
class TileSamples {
 public:
  TileSamples(const RayRandom& random, uint32_t x0, uint32_t y0);
  // Returns a sample of the pixel at (x, y) in the picture, of `samples`.
  glm::vec2 at(uint32_t x, uint32_t y, uint32_t sample, uint32_t samples) const;
  const SampleKeys& keys() const { return keys_; }

 private:
  static constexpr uint32_t side = 8, across = DepthPoints::tile_size / side;
  SampleKeys keys_;
};

inline constexpr uint32_t bias_purpose = 32;  // of the inexact test's random numbers

// Returns the light with a range no longer than where it adds `least` to a white, matt surface that faces it, in
// radiance. 0, or a directional light: the light as it is.
model::Light reaching(const model::Light& light, float least);

RayLight rays_to(const model::Light& light);
// Returns ray `index` of the pixel's `count` rays to the sky, as far as `distance`.
RayLight rays_to_the_sky(float distance, uint32_t count, uint32_t index);

// Makes the ray of one point; returns false where the light sends nothing there.
bool make_ray(const RayLight& to, const RayRandom& random, const TileSamples& samples, const DepthPoint& point,
              Ray& ray);

// Holds the rays of a tile's pixels.
class TileRays {
 public:
  explicit TileRays(const PointKernels& kernels = point_kernels()) : kernels_(&kernels) {}

  // Makes the rays of all points that the light sends something to, block by block.
  void make(const RayLight& to, const RayRandom& random, const TileSamples& samples, const PointTile& tile);
  // The same for the sky: directions are drawn by the light that it sends; black parts get none. Weights are 1
  // afterwards.
  void make(const RayLight& to, const SkyDirections& sky, const RayRandom& random, const TileSamples& samples,
            const PointTile& tile);
  void clear() { count_ = 0, drawn_ = false; }
  void push_back(const Ray& ray, uint32_t pixel);
  // Keeps the rays whose number keep(number) accepts.
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
  float weight(uint32_t ray) const { return drawn_ ? weight_[pixel_[ray]] : 1.0f; }  // as SkyDirections::Draw has it
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
  float weight_[point_tile_pixels];  // where they are drawn, by pixel
  RaySamples samples_;
};

}  // namespace sideray::rt
