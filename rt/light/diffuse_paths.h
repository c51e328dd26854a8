// Follows light backward from matt surfaces: a ray in a direction drawn by the cosine, on from what it hits, and so on. Russian
// roulette by what each surface reflects ends a path, so that all bounces count and their number adapts to how bright the
// surfaces are: dark scenes cost one. Every surface is lit by one of its lights, drawn by what they add, with a shadow ray; by
// its own emission; and by the surroundings where the ray that goes on leaves the scene: by what comes from about that
// direction, so that no texel of the sun is met by chance.
// Surfaces reflect as matt ones of their albedo. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/light/direct_light.h"
#include "rt/light/secondary_hits.h"
#include "rt/light/straight_light.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// Of a path; what is left then is less than a hundredth in the whitest rooms.
inline constexpr uint32_t most_path_surfaces = 16;

class DiffusePaths {
 public:
  // The caller keeps all arguments. `host` shades what paths hit in place of the built-in model, and then they end there: it
  // knows its own ambient light; null: the built-in model.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, SecondaryHitShader* host);
  // Follows a path along each ray: `keys` are of random numbers, one a path. Writes the radiance that comes from surfaces along
  // them, black where a ray leaves the scene, and how near the first surface is: 1 / distance, 0 where there is none.
  void follow(std::span<const Ray> rays, std::span<const Cone> cones, std::span<const uint32_t> keys, glm::vec3* radiance,
              float* nearness);

  uint64_t rays = 0, rays_shadow = 0;  // traversals since begin()

 private:
  struct Path {
    uint32_t number;    // of the ray that it began with
    glm::vec3 through;  // what surfaces and glass leave of the light from where it goes on
    uint32_t key;
  };
  void trace(std::span<const Ray> rays);
  void tint(std::span<const Ray> rays);
  void drop_misses();
  void choose_ways_on(uint32_t bounce);
  void find_sky();
  void show_sky();
  void shade();
  void go_on();

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  SecondaryHitShader* host_ = nullptr;
  bool shadows_ = true, has_sky_ = false;
  SurfaceBatch batch_;
  EnvironmentLanes environment_;
  DirectLight light_;
  StraightLight straight_;

  std::vector<Path> paths_;  // that have hit a surface each
  std::vector<Ray> rays_, tinted_;
  std::vector<Cone> cones_;
  std::vector<Hit> hits_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> points_;  // those surfaces
  std::vector<glm::vec3> light_of_points_;
  // Of the rays that go on from the points: those of paths that end there only ask for the sky.
  std::vector<Ray> next_, ends_;
  std::vector<uint32_t> next_points_, end_points_;
  std::vector<glm::vec3> reflected_;  // of next_: the path's share of what comes along it
  std::vector<Hit> next_hits_;
  std::vector<glm::vec3> ways_, sky_;  // of the ray that goes on from each point: its direction, and the sky's light there
  std::vector<uint8_t> hidden_, open_;
};

}  // namespace sideray::rt
