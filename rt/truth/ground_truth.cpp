#include "rt/truth/ground_truth.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "rt/layers/frame_pixels.h"
#include "rt/reference/ray_batches.h"
#include "rt/refraction/refraction_tracer.h"
#include "rt/truth/path_frame.h"

namespace sideray::rt {
namespace {

constexpr size_t pixels_in_truth_chunk = 1024;  // for any thread count
// The end of a path counts as visible if the straight ray hits the same object, at most this share of the distance in
// front.
constexpr double at_place = 1e-4;
constexpr float farthest_end = 1e30f;

// Is the scratch memory of one thread.
struct TruthWorker {
  RefractionTracer refraction;
  std::vector<Ray> rays;
  std::vector<Hit> opaque, glass;
  std::vector<uint32_t> counts;
  std::vector<PixelRequest> glazed;  // pixels whose paths may be bent
  std::vector<PathEnd> ends;         // of the glazed pixels
};

// Describes a straight ray from the eye to the end of a bent path, which tells whether that is directly visible.
struct PlaceRay {
  size_t texel;
  uint32_t instance;  // that the path ended at, or no_instance
  double distance;    // of the place
};

class TruthPass {
 public:
  TruthPass(const GroundTruthRequest& request, const ShadingScene& scene, const Intersector& intersector,
            const RefractionScene* refraction, GroundTruthImage& image)
      : request_(request),
        scene_(scene),
        intersector_(intersector),
        image_(image),
        view_(request.view, request.width, request.height) {
    const Ray middle = view_.ray(request.width / 2, request.height / 2);
    near_ = depth_at(middle, static_cast<double>(middle.t_near));
    far_ = middle.t_far >= farthest_end ? std::numeric_limits<double>::infinity()
                                        : depth_at(middle, static_cast<double>(middle.t_far));
    if (refraction)
      paths_.emplace(request.view, view_, request.width, request.height, scene, intersector, *refraction);
  }

  void trace(std::span<const PixelRequest> pixels, TruthWorker& w) {
    find_first(pixels, w);
    for (size_t i = 0; i < pixels.size(); ++i) store_first(pixels[i], i, w);
    if (request_.behind) follow(pixels, w);
  }

 private:
  size_t texel_of(const PixelRequest& p) const { return size_t{p.y} * request_.width + p.x; }
  double depth_at(glm::dvec3 point) const { return glm::dot(request_.depth_plane, glm::dvec4(point, 1.0)); }
  double depth_at(const Ray& ray, double distance) const { return depth_at(point_at(ray, distance)); }
  static glm::dvec3 point_at(const Ray& ray, double distance) {
    return glm::dvec3(ray.origin) + distance * glm::dvec3(ray.direction);
  }

  SeenSurface seen(const Hit& hit, const Ray& ray, Cone cone) const {
    return {scene_.snapshot->instances[hit.instance].surface_id, hit.primitive + 1,
            static_cast<float>(depth_at(ray, hit.distance)), surface_point(scene_, hit, ray, cone).surface.normal};
  }

  // Finds the first opaque surface of each ray, and the first translucent one in front of it.
  void find_first(std::span<const PixelRequest> pixels, TruthWorker& w) const {
    w.rays.clear();
    for (const PixelRequest& p : pixels) w.rays.push_back(view_.ray(p.x, p.y));
    trace_drawn_surfaces(intersector_, view_.alpha_cone(), w.rays, w.opaque);
    std::vector<Ray> before = w.rays;
    for (size_t i = 0; i < before.size(); ++i)
      if (w.opaque[i].instance != no_instance)
        before[i].t_far = static_cast<float>(w.opaque[i].distance) * (1.0f - on_opaque_surface);
    w.glass.resize(pixels.size());
    w.counts.resize(pixels.size());
    intersector_.nearest_layers(LayerSet::all_translucent, before, {.coherent = true, .cone = view_.alpha_cone()}, w.glass.data(),
                                w.counts.data());
    for (size_t i = 0; i < pixels.size(); ++i)
      if (w.counts[i] == 0) w.glass[i].instance = no_instance;
  }

  void store_first(const PixelRequest& p, size_t i, const TruthWorker& w) {
    const Cone cone = view_.cone(p.x, p.y);
    SeenSurface& first = image_.first[texel_of(p)];
    if (w.glass[i].instance != no_instance)
      first = image_.glass[texel_of(p)] = seen(w.glass[i], w.rays[i], cone);
    else if (w.opaque[i].instance != no_instance)
      first = seen(w.opaque[i], w.rays[i], cone);
  }

  void follow(std::span<const PixelRequest> pixels, TruthWorker& w) {
    find_ends(pixels, w);
    std::vector<Ray> rays;
    std::vector<PlaceRay> places;
    for (size_t i = 0; i < pixels.size(); ++i)
      store_straight(pixels[i], w.opaque[i], w.rays[i], image_.behind[texel_of(pixels[i])]);
    for (size_t i = 0; i < w.glazed.size(); ++i)
      if (w.ends[i].turns > 0) store_bent(w.glazed[i], w.ends[i], image_.behind[texel_of(w.glazed[i])], rays, places);
    look_at_places(rays, places);
  }

  // A path can be bent first only by a visible surface or by the medium around the eye.
  void find_ends(std::span<const PixelRequest> pixels, TruthWorker& w) {
    w.glazed.clear();
    for (size_t i = 0; paths_ && i < pixels.size(); ++i) {
      paths_->end_ray(pixels[i], w.rays[i], w.opaque[i]);
      if (w.glass[i].instance != no_instance || !paths_->context().at_eye.empty()) w.glazed.push_back(pixels[i]);
    }
    Counters unread;
    if (!w.glazed.empty()) w.refraction.find_ends(paths_->context(), w.glazed, w.ends, unread);
  }

  void store_straight(const PixelRequest& p, const Hit& opaque, const Ray& ray, PathTruth& path) const {
    path.place = {static_cast<float>(p.x) + 0.5f, static_cast<float>(request_.height - p.y) - 0.5f};
    path.seen = PlaceState::visible;
    if (opaque.instance == no_instance) return;
    path.end = seen(opaque, ray, view_.cone(p.x, p.y));
    path.length = static_cast<float>(opaque.distance);
  }

  void store_bent(const PixelRequest& p, const PathEnd& end, PathTruth& path, std::vector<Ray>& rays,
                  std::vector<PlaceRay>& places) const {
    path = {};
    path.turns = end.turns;
    path.state = PathState::unfinished;
    if (!end.complete) return;
    const bool on_surface = end.opaque.instance != no_instance;
    path.state = on_surface ? PathState::surface : PathState::surroundings;
    if (on_surface) {
      path.end = seen(end.opaque, end.ray, view_.cone(p.x, p.y));
      path.length = static_cast<float>(end.length + end.opaque.distance);
    }
    const glm::dvec4 place = on_surface ? glm::dvec4(point_at(end.ray, end.opaque.distance), 1.0)
                                        : glm::dvec4(glm::dvec3(end.ray.direction), 0.0);
    path.seen = project(place, path.place);
    if (path.seen != PlaceState::visible) return;
    places.push_back({texel_of(p), end.opaque.instance, 0.0});
    rays.push_back(ray_to(place, places.back().distance));
  }

  // Projects a position (w = 1) or a direction (w = 0) into the picture.
  PlaceState project(glm::dvec4 place, glm::vec2& pixel) const {
    const double depth = glm::dot(request_.depth_plane, place);
    if (view_.perspective() ? depth <= 0.0 : place.w == 0.0) return PlaceState::undefined;
    const glm::dvec4 clip = request_.view.clip_from_local * place;
    const glm::dvec2 ndc = glm::dvec2(clip) / clip.w;
    pixel = {static_cast<float>((ndc.x + 1.0) * 0.5 * request_.width),
             static_cast<float>((1.0 - ndc.y) * 0.5 * request_.height)};
    const bool inside = pixel.x >= 0.0f && pixel.y >= 0.0f && pixel.x <= static_cast<float>(request_.width) &&
                        pixel.y <= static_cast<float>(request_.height);
    const bool between = place.w == 0.0 || (depth >= near_ && depth <= far_);
    return inside && between ? PlaceState::visible : PlaceState::outside;
  }

  // Makes the straight ray to a place; `distance` is the place's on that ray, infinite for the surroundings.
  Ray ray_to(glm::dvec4 place, double& distance) const {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(request_.depth_plane));
    const glm::dvec3 to_place = glm::dvec3(place) - place.w * view_.eye();
    const bool perspective = view_.perspective();
    const glm::dvec3 direction = perspective ? glm::normalize(to_place) : axis;
    const double cosine = glm::dot(direction, axis);
    distance = place.w == 0.0 ? std::numeric_limits<double>::infinity()
                              : (depth_at(glm::dvec3(place)) - (perspective ? 0.0 : near_)) / cosine;
    const glm::dvec3 origin = perspective ? view_.eye() : glm::dvec3(place) - distance * axis;
    const double end = place.w == 0.0 ? far_ / cosine : distance * (1.0 + at_place);
    return {glm::vec3(origin), perspective ? static_cast<float>(near_ / cosine) : 0.0f, glm::vec3(direction),
            static_cast<float>(std::min(end, static_cast<double>(farthest_end)))};
  }

  // Marks places that other surfaces hide.
  void look_at_places(const std::vector<Ray>& rays, const std::vector<PlaceRay>& places) {
    if (rays.empty()) return;
    std::vector<Hit> hits;
    trace_drawn_surfaces(intersector_, view_.alpha_cone(), rays, hits);
    for (size_t i = 0; i < places.size(); ++i) {
      const PlaceRay& place = places[i];
      const bool is_there = hits[i].instance == place.instance &&
                            (place.instance == no_instance || hits[i].distance >= place.distance * (1.0 - at_place));
      if (!is_there) image_.behind[place.texel].seen = PlaceState::hidden;
    }
  }

  const GroundTruthRequest& request_;
  const ShadingScene& scene_;
  const Intersector& intersector_;
  GroundTruthImage& image_;
  ViewRays view_;
  double near_ = 0.0, far_ = 0.0;  // depths of the planes
  std::optional<PathFrame> paths_;  // empty if nothing bends light
};

}  // namespace

GroundTruthImage GroundTruthTracing::trace(const GroundTruthRequest& request, TracedScene& scene) {
  const ShadingScene& shading = scene.shading();
  const RefractionScene* refraction =
      request.behind && bends_light(*shading.snapshot) ? &refraction_.of(shading.snapshot) : nullptr;
  const size_t texels = size_t{request.width} * request.height;
  GroundTruthImage image{std::vector<SeenSurface>(texels), std::vector<SeenSurface>(texels),
                         std::vector<PathTruth>(request.behind ? texels : 0)};
  const FramePixels frame = every_pixel(request.width, request.height, scene.executor());
  TruthPass pass(request, shading, scene.intersector(), refraction, image);
  std::vector<TruthWorker> workers(scene.executor().threads());
  trace_in_chunks(frame, pixels_in_truth_chunk, scene.executor(), [&](std::span<const PixelRequest> pixels, uint32_t thread) {
    pass.trace(pixels, workers[thread]);
  });
  return image;
}

}  // namespace sideray::rt
