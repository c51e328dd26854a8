// Follows the rays of a chunk of pixels through translucent surfaces, refracted by solids, and adds up their light, in
// rounds of one surface a path that are traversed and shaded in batches. It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/layers/layer_tracer.h"
#include "rt/refraction/next_surfaces.h"
#include "rt/refraction/refracted_path.h"
#include "rt/refraction/refraction.h"
#include "rt/refraction/refraction_context.h"
#include "rt/shading/ray_reuse.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

struct RefractedPixel {
  glm::vec3 radiance[2];    // as many estimates as the shader makes
  glm::vec3 transmittance;  // to the background along the unrefracted ray
  glm::vec3 sky;            // transmittance of refracted rays to the surroundings, which radiance includes
  // For the filter, if rough surfaces scattered the ray, each in one random direction: perceptual roughness of the
  // first one (0: none was rough); width of its transmission lobe relative to its reflection lobe; 1 / length of the
  // path to the visible surface (0: the environment).
  float roughness, spread, nearness;
};

// Holds the first surface on a straight primary ray that bends light.
struct FirstBend {
  Hit hit;
  Ray ray;
  Cone cone;
  uint32_t key;     // of its pixel, for random numbers
  uint32_t before;  // number of surfaces that the ray hit before
  RayReuse::Pixel pixel;
  bool is_lit;      // the surface's own light has been added
};

// Holds the end of a path that was followed without shading.
struct PathEnd {
  Ray ray;         // its last straight part
  Hit opaque;      // the surface at its end; no_instance: none, or `turns` is 0 and it is not searched
  double length;   // of the parts before it
  uint32_t turns;  // surfaces that refracted or reflected it
  bool complete;   // false: the path reached the limit of surfaces
};

// Holds a translucent surface that a path crossed or that reflected it.
struct PathSurface {
  uint32_t path;  // index of its pixel
  Hit hit;
  Ray ray;         // the straight part of the path that hit it
  double length;   // of the parts before it
  glm::vec3 normal, geometric_normal;  // shading normal and the triangle's, unit, on the side of the ray
};

class RefractionTracer {
 public:
  // The most surfaces that a path hits, even in unlimited requests: some paths never leave a solid.
  static constexpr uint32_t most_events = 256;
  // The most surfaces that a path hits after its first refraction, including that one.
  static constexpr uint32_t most_events_behind = 8;
  // At its first rough surface, a path of a reference splits into this many directions, half of them for each of the
  // two estimates. At further rough surfaces, and in frames, it continues in one direction.
  static constexpr uint32_t scattered_paths = 8;

  // `shader` must have begun. Refills `result`; adds the work to `counters`. Returns other than complete if the shader
  // stopped early; then the result is invalid.
  TraceEnd trace(const RefractionContext& context, std::span<const PixelRequest> pixels, PointShader& shader,
                 std::vector<RefractedPixel>& result, Counters& counters);

  // Starts at the first surfaces that bend light, and writes the light behind each, all of it along refracted rays:
  // result[i] belongs to bends[i]. Every path is traced; with LayerRequest::ray_reuse, pixels share shadow and mirror
  // rays of the crossed surfaces.
  TraceEnd follow(const RefractionContext& context, std::span<const FirstBend> bends, PointShader& shader,
                  std::vector<RefractedPixel>& result, Counters& counters);

  // Follows the same paths without shading: rough surfaces refract like smooth ones, and no path ends for lack of
  // light. Refills `ends`: ends[i] belongs to pixels[i]. If `surfaces` is not null, refills it with the surfaces that
  // the paths hit, in order along each path.
  void find_ends(const RefractionContext& context, std::span<const PixelRequest> pixels, std::vector<PathEnd>& ends,
                 Counters& counters, std::vector<PathSurface>* surfaces = nullptr);

 private:
  struct Share {
    uint32_t pixel;
    int estimate;
    glm::vec3 weight;
  };
  static constexpr int both_estimates = RefractedPath::both_estimates;

  void begin(const RefractionContext& context, PointShader& shader, std::vector<RefractedPixel>& result,
             Counters& counters);
  RefractedPath& path_from_eye(uint32_t path, uint32_t key, const Ray& ray, Cone cone);
  void start(std::span<const PixelRequest> pixels);
  void start(std::span<const FirstBend> bends);
  TraceEnd run();
  void advance_all();
  void advance(uint32_t path);
  bool meets(uint32_t path, const Hit& hit, SurfacePoint* surface, bool is_lit = false);
  void pass(uint32_t path, const Hit& hit, SurfacePoint& point, const Crossing& crossing, const MediumStack& behind,
            bool is_lit);
  void reflect_totally(RefractedPath& path, const SurfacePoint& point, const Crossing& crossing, const MediumStack& behind,
                       glm::vec3 mirrored) const;
  void disperse(uint32_t path, const SurfacePoint& point, const Hit& hit, const MediumStack& before);
  void scatter(uint32_t path, const SurfacePoint& point, const Crossing& crossing);
  void widen(const RefractedPath& path, const SurfacePoint& point, const Crossing& crossing);
  void redirect(RefractedPath& path, const SurfacePoint& point, glm::vec3 direction, bool transmitted) const;
  void blend(RefractedPath& path, const SurfacePoint& point, bool is_lit);
  bool finished(const RefractedPath& path) const;
  void end(uint32_t path);
  void add(const Share& share, const glm::vec3* radiance);
  void shade_events();
  void shade_ends();
  void add_points();

  const RefractionContext* context_ = nullptr;
  PointShader* shader_ = nullptr;
  Counters* counters_ = nullptr;
  std::vector<RefractedPixel>* result_ = nullptr;
  std::vector<PathEnd>* path_ends_ = nullptr;  // output of paths without shading; otherwise null
  std::vector<PathSurface>* path_surfaces_ = nullptr;  // the same, if the surfaces are requested
  std::vector<RefractedPath> paths_;
  std::vector<uint32_t> active_, next_active_, ends_;
  NextSurfaces next_surfaces_;
  const ShadeKernels* kernels_ = nullptr;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> points_;
  std::vector<MediumStack> media_;  // one for each of points_, like the next
  std::vector<Share> shares_;
  RayReuse reuse_;
  std::span<const FirstBend> bends_;           // of paths that reuse rays; donors come first in active_
  std::vector<uint32_t> order_;                // of bends_
  std::vector<RayReuse::Pixel> point_pixels_;  // pixels of points_, for reuse_
  std::vector<glm::vec3> radiance_;
};

}  // namespace sideray::rt
