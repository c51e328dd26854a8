// Computes the light that leaves surfaces toward the viewer by paths of any number of bounces (docs/adr/0028-paths.md):
// surfaces light each other, occlude the environment and cast caustics. Holds scratch memory: one object per thread.
#pragma once

#include <vector>

#include "rt/reference/emitters.h"
#include "rt/reference/lamp_guide.h"
#include "rt/reference/light_way.h"
#include "rt/reference/reference_lobes.h"
#include "rt/reference/reference_shader.h"

namespace sideray::rt {

struct PathSettings {
  uint32_t samples;  // paths of each point, at least 1
  uint32_t bounces;  // how many surfaces may reflect the light of a path, at least 1; 0 = unlimited
  bool shadows;      // whether anything stands in the way of lights
  bool caustics;     // whether lamps and shining surfaces are found by what bends light alone, where they have a size
};

class PathShader final : public PointShader {
 public:
  // Sets what is shaded until the next call; the caller keeps it. `refraction` null: nothing bends light.
  void begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
             const PathSettings& settings);

  // The estimates are two independent halves of the samples, as those of ReferenceShader.
  uint32_t estimates() const override { return 2; }
  void within(const MediumStack* media) override { media_ = media; }
  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override { shade(points, radiance); }
  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;

 private:
  struct Path {
    LightWay way;
    uint32_t point;      // index of the point whose light the path carries
    uint32_t key;        // of the path's own random numbers; those that samples share are made of the point's
    uint32_t bounces;    // how many surfaces have reflected the light
    uint32_t events;     // how many surfaces it has met in all
    glm::vec3 weight;    // what the point makes of radiance along the way
    float density;       // that of the ray's direction, where what it meets is sampled too; 0 where it is not
    LitPoint from;       // where the ray comes from, as it is sampled for
    glm::vec3 bent_share;  // what of a shining surface's light counts that the ray finds once it is bent
  };
  // Holds a ray to a light, or to the environment.
  struct Beam {
    LightWay way;
    uint32_t point;
    glm::vec3 gain;       // what the light adds where nothing is in its way
    glm::vec3 bent_gain;  // the same where something on its way bends light; 0: paths find that
    bool is_bent;         // whether something did: `gain` is bent_gain then
  };
  // Says what a beam goes to: lamps are blocked by what casts shadows, the environment and surfaces by what paths meet.
  enum class Target { lamp, scene };
  // Says how one of the lights is sampled at a point.
  struct LitBy {
    const ReferenceLight* light;
    LightCone cone;    // of a light with a size
    shading::SrIncidence incidence;
    float chance;      // of being chosen
  };
  // Says which samples are drawn now.
  struct Drawing {
    uint32_t half, sample;
  };

  void add_exact_lights(std::span<const SurfacePoint> points);
  void trace_paths(std::span<const SurfacePoint> points);
  Path path_of(const SurfacePoint& point, uint32_t index) const;
  void advance(Path& path);
  bool meet(Path& path, WayEvent& event);
  glm::vec3 counted(const Path& path, const Hit& hit) const;
  void end(Path& path);
  void bounce(Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  bool leave(Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void bend(Path& path, const WayEvent& event, glm::vec3 direction);
  void find_lights(const SurfacePoint& point, bool all);
  void sample_lights(const Path& path, const SurfacePoint& point, const LobeSampler& lobes, bool all);
  void sample_light(const Path& path, const SurfacePoint& point, const LobeSampler& lobes, const LitBy& lit,
                    uint32_t purpose);
  void sample_sky(const Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void sample_emitter(const Path& path, const SurfacePoint& point, const LobeSampler& lobes);
  void meet_lights(const Path& path, const SurfacePoint& point, glm::vec3 direction, float density);
  float density(const LobeSampler& lobes, glm::vec3 direction) const;
  bool is_found(const ReferenceLight& light) const { return light.is_wide() || (settings_.caustics && light.sized()); }
  void meet_lights_bent(const Path& path, const SurfacePoint& point);
  void add_beam(const Path& path, const LightWay& way, glm::vec3 gain, glm::vec3 bent_gain, Target target);
  LightWay beam_from(const Path& path, const SurfacePoint& point, glm::vec3 direction, float length) const;
  void end_beams();
  void end_beams(std::vector<Beam>& beams, OpaqueSet blockers);
  void pass_translucent(std::vector<Beam>& beams);
  bool dims(Beam& beam);

  bool may_bounce(const Path& path) const { return settings_.bounces == 0 || path.bounces < settings_.bounces; }
  MediumStack media_of(size_t point) const { return media_ ? media_[point] : MediumStack{}; }
  glm::vec2 random_point(const Path& path, uint32_t purpose) const;

  ReferenceScene scene_{};
  const EmitterSampler* emitters_ = nullptr;
  PathSettings settings_{};
  LightWays ways_;
  Drawing drawing_{};
  const MediumStack* media_ = nullptr;
  std::span<const SurfacePoint> points_;
  std::vector<LobeSampler> lobes_;  // of the points
  std::vector<glm::vec3> sums_;     // of the points
  std::vector<Path> paths_, next_paths_;
  std::vector<Beam> light_beams_, scene_beams_;
  std::vector<LitBy> lit_;
  LampGuide guide_;           // of the point that reflects now, as the next
  float guided_ = 0.0f;       // the share of the directions that it samples

  std::vector<LightWay*> group_;  // scratch memory, as the next
  std::vector<Ray> rays_;
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
