// Follows the rays of a chunk of pixels through everything translucent, refracted by solids, and adds up what they see:
// rounds of one surface a path, traversed and shaded in batches. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/layers/layer_tracer.h"
#include "rt/refraction/refraction.h"
#include "rt/refraction/surfaces_ahead.h"
#include "rt/shading/ray_reuse.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

struct RefractedPixel {
  glm::vec3 radiance[2];    // as many estimates as the shader makes
  glm::vec3 transmittance;  // transmittance to what stands behind the ray that is not refracted
  glm::vec3 sky;            // transmittance of refracted rays to the surroundings, which radiance holds already
  // For the filter, if rough surfaces scattered the ray, each in one random direction: the perceptual roughness of the
  // first one (0: none was rough); the width of its transmitted lobe relative to its mirror lobe; and 1 / length of the
  // path to what is seen (0: the environment).
  float roughness, spread, nearness;
};

// Holds what all chunks of a frame share.
struct RefractionContext {
  const FrameContext* frame;
  const RefractionScene* scene;
  MediumStack at_eye;  // media at the eye of a perspective view
  bool exact;  // many directions leave a rough surface, and rays continue to the last visible surface
};

RefractionContext refraction_context(const FrameContext& frame, const RefractionScene& scene, bool exact);

// Returns the solids that a point is in, the innermost on top.
MediumStack media_at(const RefractionScene& scene, const Intersector& intersector, glm::vec3 point);

// Holds the first surface along a straight ray from the eye that bends light.
struct FirstBend {
  Hit hit;
  Ray ray;
  Cone cone;
  uint32_t key;     // of its pixel, for random numbers
  uint32_t before;  // how many surfaces the ray hit before it
  RayReuse::Pixel pixel;
  bool is_lit;      // the surface's own light has been added already
};

// Holds where a path ended that was followed for its way alone.
struct PathEnd {
  Ray ray;         // its last straight part
  Hit opaque;      // the surface that this part ends at; no_instance: none, or `turns` is 0 and it is not looked for
  double length;   // of the parts before it
  uint32_t turns;  // surfaces that refracted or reflected it
  bool complete;   // it was followed to its end; false: it reached the limit of surfaces
};

// Holds a translucent surface that a path crossed, or was reflected by.
struct PathSurface {
  uint32_t path;  // index of its pixel
  Hit hit;
  Ray ray;         // the straight part of the path that hit it
  double length;   // of the parts before that
  glm::vec3 normal, geometric_normal;  // shading normal and the triangle's, unit, on the side of the ray
};

class RefractionTracer {
 public:
  // A path hits at most this many surfaces, even where requests are unlimited: some paths never leave a solid.
  static constexpr uint32_t most_events = 256;
  // A path from a first refraction hits at most this many surfaces, that one included.
  static constexpr uint32_t most_events_behind = 8;
  // At its first rough surface a path of a reference splits into this many directions, half of them for each of the two
  // estimates. At further rough surfaces, and in frames, it continues in one direction.
  static constexpr uint32_t scattered_paths = 8;

  // `shader` has begun. Refills `result`; adds what was done to `counters`. Other than complete: the shader did not
  // come to the end, and the result is void.
  TraceEnd trace(const RefractionContext& context, std::span<const PixelRequest> pixels, PointShader& shader,
                 std::vector<RefractedPixel>& result, Counters& counters);

  // Starts at the surfaces that bend light first, and writes what is seen there, all of it along refracted rays:
  // result[i] is that of bends[i]. Every path is traced; under LayerRequest::ray_reuse shadow and mirror rays of the
  // surfaces that it crosses are reused from pixel to pixel.
  TraceEnd follow(const RefractionContext& context, std::span<const FirstBend> bends, PointShader& shader,
                  std::vector<RefractedPixel>& result, Counters& counters);

  // Follows the same paths for their ways alone: nothing is shaded, rough surfaces refract as smooth ones do, and no path
  // ends for want of light. Refills `ends`: ends[i] is that of pixels[i]. Where `surfaces` is not null it is refilled with
  // what the paths hit, each path's in their order.
  void find_ends(const RefractionContext& context, std::span<const PixelRequest> pixels, std::vector<PathEnd>& ends,
                 Counters& counters, std::vector<PathSurface>* surfaces = nullptr);

 private:
  // Says what has to be found before a path can go on. Most refracted rays turn at the first surface that they hit: so
  // only its place is looked for, and opaque surfaces as far as there. Of a ray that goes straight on the opaque surface is
  // found first, and then several translucent ones at once: the rest.
  enum class Search : uint8_t { nothing, place, opaque, rest };
  struct Path {
    uint32_t pixel, key;
    uint32_t met, wanted;
    int estimate;  // the estimate that it counts for, or both_estimates
    Light light;   // that it carries
    Ray ray;
    Cone cone;
    glm::vec3 through;
    float start;  // distance along the ray up to which its medium has absorbed
    float way;    // length of the refracted rays before this one
    double length;   // of all rays before this one
    uint32_t turns;  // rays before this one
    MediumStack media;
    bool refracted;
    float clear;    // of a refracted ray: nothing opaque is nearer; `farthest`: its end has been found
    Hit opaque;     // where a refracted ray ends
    SurfacesAhead ahead;
    Search search;
    uint32_t surface;  // index in made_ of the surface of ahead.hits[0], then of `next`; or none
    Hit next;          // the surface that it crosses next; no_instance: it ends
    float way_out;     // where its medium ends behind the last surface that counts; or infinite
  };
  struct Share {
    uint32_t pixel;
    int estimate;
    glm::vec3 weight;
  };
  static constexpr int both_estimates = -1;
  static constexpr uint32_t none = 0xffffffffu;

  void begin(const RefractionContext& context, PointShader& shader, std::vector<RefractedPixel>& result,
             Counters& counters);
  Path& path_from_eye(uint32_t path, uint32_t key, const Ray& ray, Cone cone);
  void start(std::span<const PixelRequest> pixels);
  void start(std::span<const FirstBend> bends);
  TraceEnd run();
  void advance_all();
  void find_next();
  void find_places();
  void find_opaque();
  void find_layers();
  void traverse_group(uint32_t layers, bool cull);
  Cone common_cone() const;
  bool sees_culled(const Path& path) const { return path.refracted || !path.media.empty(); }
  Search next_search(const Path& path) const;
  bool wants_end(const Path& path) const;
  bool absorbs(const Path& path) const;
  void make_surfaces(size_t first);
  void make_next_surfaces();
  bool settle(Path& path) const;
  bool find_way_out(Path& path) const;
  bool counts(Path& path, const Hit& hit) const;
  void take_next(Path& path) const;
  void advance(uint32_t path);
  bool meets(uint32_t path, const Hit& hit, SurfacePoint* surface, bool is_lit = false);
  void pass(uint32_t path, const Hit& hit, SurfacePoint& point, const Crossing& crossing, const MediumStack& behind,
            bool is_lit);
  void disperse(uint32_t path, const SurfacePoint& point, const Hit& hit, const MediumStack& before);
  void scatter(uint32_t path, const SurfacePoint& point, const Crossing& crossing);
  void widen(const Path& path, const SurfacePoint& point, const Crossing& crossing);
  void redirect(Path& path, const SurfacePoint& point, glm::vec3 direction, bool transmitted) const;
  void blend(Path& path, const SurfacePoint& point, bool is_lit);
  bool finished(const Path& path) const;
  void end(uint32_t path);
  void add(const Share& share, const glm::vec3* radiance);
  void shade_events();
  void shade_ends();
  void add_points();

  const RefractionContext* context_ = nullptr;
  PointShader* shader_ = nullptr;
  Counters* counters_ = nullptr;
  std::vector<RefractedPixel>* result_ = nullptr;
  std::vector<PathEnd>* path_ends_ = nullptr;  // output where paths are followed without shading; otherwise null
  std::vector<PathSurface>* path_surfaces_ = nullptr;  // likewise, if the surfaces that they hit are asked for
  std::vector<Path> paths_;
  std::vector<uint32_t> active_, next_active_, pending_, group_, ends_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<uint32_t> hit_counts_;
  std::vector<double> known_;
  const ShadeKernels* kernels_ = nullptr;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> made_;  // surfaces of the paths' next hits; grows only
  size_t made_count_ = 0;
  std::vector<SurfacePoint> points_;
  std::vector<MediumStack> media_;  // one for each of points_, as the next
  std::vector<Share> shares_;
  RayReuse reuse_;
  std::span<const FirstBend> bends_;           // of paths that reuse rays; donors are in front in active_
  std::vector<RayReuse::Pixel> point_pixels_;  // of reuse_: those of points_
  std::vector<glm::vec3> radiance_;
};

}  // namespace sideray::rt
