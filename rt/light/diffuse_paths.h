// Follows light paths backward from diffuse surfaces, with directions sampled by the cosine. Russian roulette by albedo
// ends a path, so that all bounces are included and their number adapts to the surfaces: in dark scenes it is one.
// Every point is lit by one of its lights, sampled by its contribution, and by a sampled emitter, with a shadow ray each;
// and by the environment if its next ray leaves the scene. That radiance is averaged about the ray's direction, so that no
// path hits single texels of the sun. Surfaces reflect as diffuse ones of their albedo. It has scratch memory: one
// object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/light/direct_light.h"
#include "rt/light/emitted_light.h"
#include "rt/light/secondary_hits.h"
#include "rt/light/straight_light.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// In a path; after so many, less than a hundredth of the light is left even in the whitest rooms.
inline constexpr uint32_t most_path_surfaces = 16;

// Refers to the starts of paths: rays with directions sampled by the cosine about the normals, widths of a pixel there,
// and keys of random numbers.
struct PathStarts {
  std::span<const Ray> rays;
  std::span<const glm::vec3> normals;
  std::span<const float> widths;
  std::span<const uint32_t> keys;
};

// Describes the light that a path finds at its start.
struct PathLight {
  glm::vec3 radiance{0.0f};       // estimate of that of surfaces, averaged over the cosine
  float nearness = 0.0f;          // 1 / distance of the first hit; 0: the ray leaves the scene
  float emitter_nearness = 0.0f;  // 1 / distance of a sampled emitter times its share of the radiance
};

class DiffusePaths {
 public:
  // The caller keeps all arguments alive. `host` shades hits instead of the built-in model, and paths end there,
  // because the host knows its own ambient light; null: the built-in model.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, SecondaryHitShader* host);
  // Follows a path from each start.
  void follow(const PathStarts& starts, PathLight* light);

  uint64_t rays = 0, rays_shadow = 0;  // traversals since begin()

 private:
  struct Path {
    uint32_t number;    // index of its first ray
    glm::vec3 through;  // transmittance and reflectance up to the current ray
    uint32_t key;
    LitPoint from;      // where the current ray starts
  };
  bool samples_emitters() const { return !host_ && emitted_.is_sampled(); }
  void tint(std::span<const Ray> rays);
  void drop_misses();
  void choose_ways_on(uint32_t bounce);
  void find_sky();
  void show_sky();
  void shade();
  void share_emission(uint32_t bounce);
  void sample_first_emitters(PathLight* light);
  void go_on();

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  SecondaryHitShader* host_ = nullptr;
  bool shadows_ = true, has_sky_ = false;
  SurfaceBatch batch_;
  EnvironmentLanes environment_;
  DirectLight light_;
  StraightLight straight_;
  EmittedLight emitted_;

  std::vector<Path> paths_;  // those with a hit
  std::vector<Ray> rays_, tinted_;
  std::vector<Cone> cones_;
  std::vector<Hit> hits_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> points_;  // the hit surfaces
  std::vector<glm::vec3> light_of_points_;
  // Rays that continue from the points; rays of paths that end there only test for the sky.
  std::vector<Ray> next_, ends_;
  std::vector<uint32_t> next_points_, end_points_;
  std::vector<glm::vec3> reflected_;  // for next_: the path's reflectance
  std::vector<Hit> next_hits_;
  std::vector<glm::vec3> ways_;             // direction of each point's next ray
  std::vector<glm::vec3> open_ways_, sky_;  // those that leave the scene, and the sky's light there
  std::vector<uint8_t> hidden_, open_;
};

}  // namespace sideray::rt
