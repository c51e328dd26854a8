// Holds hits as arrays of numbers and shades them sixteen at a time (rt/surfaces/shade_kernels.h). Traces no rays.
// Holds scratch memory: one object per thread.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "rt/surfaces/shade_kernels.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Names a hit, the unit ray that made it, and its cone at t = 0. Whoever fills it keeps both.
struct HitPlace {
  const Hit* hit;
  const Ray* ray;
  Cone cone;
};

// Appends what surface_point() makes of each hit, bit for bit. `kernels` are those of the instruction set.
void append_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                     std::vector<SurfacePoint>& points);

class SurfaceBatch {
 public:
  // The caller keeps the scene. `isa` is named as Embree does.
  void begin(const ShadingScene& scene, const std::string& isa);

  // Takes the points over, and fills around() except for what the mirror directions show, which starts black.
  void load(std::span<const SurfacePoint> points);
  // The same with the surfaces of hits.
  void load(std::span<const HitPlace> hits);

  // Lets the mirror directions show the prefiltered environment.
  void reflect_environment();

  // Writes radiance[i] = emission and light from the surroundings of point i.
  void finish(glm::vec3* radiance);

  // Computes what the light adds to every block's points.
  std::span<const LightBlock> light(const shading::SrLight& light);

  std::span<AroundBlock> around() { return around_; }

 private:
  void look_around();

  const ShadingScene* scene_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  size_t count_ = 0;
  std::vector<SurfaceBlock> blocks_;
  std::vector<AroundBlock> around_;
  std::vector<LightBlock> lights_;
};

inline glm::vec3 vector_at(const BlockRow (&rows)[3], size_t lane) {
  return {rows[0][lane], rows[1][lane], rows[2][lane]};
}

inline void set_vector(BlockRow (&rows)[3], size_t lane, glm::vec3 v) {
  rows[0][lane] = v.x;
  rows[1][lane] = v.y;
  rows[2][lane] = v.z;
}

}  // namespace sideray::rt
