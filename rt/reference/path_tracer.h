// Follows paths of light from the surfaces that the eye's rays hit, for any number of bounces (docs/adr/0028-paths.md):
// surfaces light each other, occlude the environment and cast caustics. Holds scratch memory: one object per thread.
#pragma once

#include <vector>

#include "rt/reference/beams.h"
#include "rt/reference/emitters.h"
#include "rt/reference/lamp_guide.h"
#include "rt/reference/light_way.h"
#include "rt/reference/reference_lobes.h"
#include "rt/reference/reference_shader.h"

namespace sideray::rt {

struct PathSettings {
  uint32_t bounces;  // how many surfaces may reflect the light of a path, at least 1; 0 = unlimited
  bool shadows;      // whether anything stands in the way of lights
  bool caustics;     // whether lamps and shining surfaces are found by what bends light alone, where they have a size
};

// Says where paths begin: at a surface that reflects, or behind one that the eye looks through.
struct PathStart {
  const LightWay* way;        // of the eye, up to the surface
  const SurfacePoint* point;
  const WayEvent* passed;     // of a surface that they pass; null: it reflects them
  uint32_t sum;               // to which they add
  uint32_t key;               // of their random numbers
  uint32_t first, count;      // their numbers among the paths of the key
  glm::vec3 weight;           // what each makes of radiance
};

// Returns how many of the samples one of two independent halves has.
inline uint32_t samples_of_half(uint32_t samples, uint32_t half) {
  return (samples + 1 - half) / 2;
}

// Adds up what paths find.
struct PathSum {
  glm::vec3 radiance{0.0f};
  glm::vec3 sky{0.0f};  // the share of paths from the eye that end there, reflected by nothing
};

class PathTracer {
 public:
  // Sets what is traced until the next call; the caller keeps it. `refraction` null: nothing bends light.
  void begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
             const PathSettings& settings);
  LightWays& ways() { return ways_; }
  glm::vec3 sky(glm::vec3 direction) const {
    return scene_.environment->black() ? glm::vec3(0.0f) : scene_.environment->radiance(direction);
  }

  // Adds to `sums` what lights without a size do directly at a surface that reflects, for which one ray is exact.
  // Not where paths pass.
  void add_exact_lights(const PathStart& start, std::span<PathSum> sums);
  // Adds to `sums` what the paths find of everything else. The sums of both calls are the same.
  void trace(std::span<const PathStart> starts, std::span<PathSum> sums);

  uint64_t rays_reflection = 0;
  uint64_t rays_shadow() const { return beams_.traversals; }

 private:
  struct Path {
    LightWay way;
    uint32_t sum;
    uint32_t set, number;  // of its points; other dimensions are derived from them
    uint32_t key;          // of the path's own random numbers
    uint32_t bounces;      // how many surfaces have reflected the light
    uint32_t events;       // surfaces hit in all
    glm::vec3 weight;      // what is made of radiance along the way
    float usual;           // the largest channel of its weight when it set out: roulette compares with that
    float density;         // that of the ray's direction, if what it hits is also sampled; else 0
    LitPoint from;         // origin of the ray, for the density of light samples
    glm::vec3 bent_share;  // what of a shining surface's light counts that the ray finds once it is bent
  };
  // Says how one of the lights is sampled at a point.
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
  // Of the point that reflects now.
  std::vector<LitBy> lit_;
  uint32_t draws_ = 1;   // how many of the lights a path samples there
  LampGuide guide_;
  float guided_ = 0.0f;  // the share of the directions that the guide samples
};

}  // namespace sideray::rt
