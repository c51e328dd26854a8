// Follows light paths from primary hits for any number of bounces (docs/adr/0028-paths.md): surfaces light each other,
// occlude the environment and cast caustics. It has scratch memory: one object per thread.
#pragma once

#include <vector>

#include "rt/reference/beams.h"
#include "rt/light/emitters.h"
#include "rt/reference/lamp_guide.h"
#include "rt/reference/light_way.h"
#include "rt/reference/reference_lobes.h"
#include "rt/reference/reference_shader.h"

namespace sideray::rt {

struct PathSettings {
  uint32_t bounces;  // number of surfaces that may reflect a path's light, at least 1; 0 = unlimited
  bool shadows;      // lights can be occluded
  bool caustics;     // sized lamps and emissive surfaces are refracted, not transmitted straight
};

// Describes where paths start: at a reflecting surface, or behind one that primary rays pass.
struct PathStart {
  const LightWay* way;        // the primary ray up to the surface
  const SurfacePoint* point;
  const WayEvent* passed;     // the surface that the paths pass; null: the surface reflects them
  uint32_t sum;               // index of the sum that they add to
  uint32_t key;               // of their random numbers
  uint32_t first, count;      // their numbers among all paths with this key
  glm::vec3 weight;           // of each path's radiance
};

// Returns how many of the samples belong to one of two independent halves.
inline uint32_t samples_of_half(uint32_t samples, uint32_t half) {
  return (samples + 1 - half) / 2;
}

// Adds up the light of paths.
struct PathSum {
  glm::vec3 radiance{0.0f};
  glm::vec3 sky{0.0f};  // weight of primary rays that end in the sky without a reflection
};

class PathTracer {
 public:
  // Sets the scene and settings until the next call; the caller keeps them alive. `refraction` null: nothing bends
  // light.
  void begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
             const PathSettings& settings);
  LightWays& ways() { return ways_; }
  glm::vec3 sky(glm::vec3 direction) const {
    return scene_.environment->black() ? glm::vec3(0.0f) : scene_.environment->radiance(direction);
  }

  // Adds the direct light of lights without a size at a reflecting surface to `sums`, for which one ray is exact. Not
  // for surfaces that paths pass.
  void add_exact_lights(const PathStart& start, std::span<PathSum> sums);
  // Adds all other light to `sums`. Both calls use the same sums.
  void trace(std::span<const PathStart> starts, std::span<PathSum> sums);

  uint64_t rays_reflection = 0;
  uint64_t rays_shadow() const { return beams_.traversals; }

 private:
  struct Path {
    LightWay way;
    uint32_t sum;
    uint32_t set, number;  // of its point set; numbers of other dimensions are derived from them
    uint32_t key;          // of the path's own random numbers
    uint32_t bounces;      // surfaces that have reflected the light
    uint32_t events;       // surfaces hit in all
    glm::vec3 weight;      // of radiance found along the ray
    float usual;           // largest channel of its initial weight, for Russian roulette
    float density;         // of the ray's direction, if its hit may also be sampled as a light; else 0
    LitPoint from;         // origin of the ray, for the density of light samples
    glm::vec3 bent_share;  // weight of an emissive surface's light that the ray finds after it was bent
  };
  // Says how one light is sampled at a point.
  struct LitBy {
    const ReferenceLight* light;
    LightCone cone;    // of a light with a size
    shading::SrIncidence incidence;
    float chance;      // of being chosen
  };

  void start(const PathStart& start);
  void follow();
  void advance(Path& path);
  bool meet(Path& path, WayEvent& event);
  bool pass(Path& path, WayEvent& event);
  void turn_by_facet(Path& path, WayEvent& event);
  void bend(Path& path, const WayEvent& event, glm::vec3 direction);
  void end(Path& path);
  glm::vec3 counted(const Path& path, const Hit& hit) const;

  void bounce(Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void reflect(Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  bool leave(Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  float density(const LobeSampler& lobes, glm::vec3 direction) const;

  void find_lights(const SurfacePoint& point, const LobeSampler& lobes, bool is_first);
  void sample_lights(const Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void sample_light(const Path& path, const SurfacePoint& point, const LobeSampler& lobes, const LitBy& lit, uint32_t draw);
  void sample_sky(const Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void sample_emitter(const Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void meet_lights(const Path& path, const SurfacePoint& point, glm::vec3 direction, float density);
  void meet_lights_bent(const Path& path, const SurfacePoint& point);
  bool is_found(const ReferenceLight& light) const { return light.is_wide() || (settings_.caustics && light.sized()); }

  MediumStack media_on(const LightWay& way, const SurfacePoint& point, glm::vec3 direction) const;
  Beam beam_from(const Path& path, const SurfacePoint& point, glm::vec3 direction, float length) const;
  void send(Beam beam, glm::vec3 gain, glm::vec3 bent_gain, BeamTarget target);
  void end_beams();

  bool may_bounce(const Path& path) const { return settings_.bounces == 0 || path.bounces < settings_.bounces; }
  glm::vec2 random_point(const Path& path, uint32_t purpose) const;

  ReferenceScene scene_{};
  const EmitterSampler* emitters_ = nullptr;
  PathSettings settings_{};
  LightWays ways_;
  Beams beams_;
  std::span<PathSum> sums_;
  std::vector<Path> paths_, next_paths_;
  std::vector<LightWay*> group_;  // scratch memory
  // For the point that reflects at the moment:
  std::vector<LitBy> lit_;
  uint32_t draws_ = 1;   // lights sampled by a path there
  LampGuide guide_;
  float guided_ = 0.0f;  // share of directions from the guide
};

}  // namespace sideray::rt
