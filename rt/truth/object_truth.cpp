#include "rt/truth/object_truth.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <span>

#include "rt/base/view_rays.h"
#include "rt/layers/frame_pixels.h"
#include "rt/truth/surface_walk.h"

namespace sideray::rt {
namespace {

constexpr size_t pixels_in_object_chunk = 1024;  // for any thread count
// A translucent surface less than this share of the distance in front of an opaque one counts as lying on it, as in
// ViewRays::end_of_ray.
constexpr double on_opaque = 0x1p-21;

// Records that a pixel's centre hits an object.
struct Covered {
  uint32_t object, x, y;
  bool visible;
};

// Holds the objects that one ray hits.
struct RayObjects {
  struct Met {
    uint32_t object;
    bool visible;
  };
  std::vector<Met> met;  // each object at most once
  Hit opaque, translucent;  // the first of each kind
};

// Finds the objects that each ray hits, and which of them are visible.
class ObjectRays {
 public:
  ObjectRays(const ObjectTruthRequest& request, const model::Snapshot& snapshot, const Intersector& intersector,
             const AlphaCone& cone)
      : request_(request), walk_(snapshot, intersector, cone, true) {}

  std::span<const RayObjects> trace(std::span<const Ray> rays) {
    objects_.resize(rays.size());
    for (RayObjects& o : objects_) o.met.clear(), o.opaque.instance = o.translucent.instance = no_instance;
    walk_.opaque(rays, [&](uint32_t i, const Hit& hit) { return meet_opaque(objects_[i], hit), true; });
    walk_.translucent(rays, [&](uint32_t i, const Hit& hit) { return meet_translucent(objects_[i], hit), true; });
    return objects_;
  }

 private:
  void meet_opaque(RayObjects& ray, const Hit& hit) const {
    const bool first = ray.opaque.instance == no_instance;
    if (first) ray.opaque = hit;
    add(ray, hit, first);
  }

  // Is called after all opaque surfaces. The first translucent surface in front of the opaque ones may hide the first
  // of them.
  void meet_translucent(RayObjects& ray, const Hit& hit) const {
    const bool before = ray.opaque.instance == no_instance || hit.distance < ray.opaque.distance * (1.0 - on_opaque);
    const bool first = before && ray.translucent.instance == no_instance;
    if (first) ray.translucent = hit;
    if (first && !request_.hidden_by_opaque)
      for (RayObjects::Met& met : ray.met) met.visible = false;
    add(ray, hit, before && (first || request_.hidden_by_opaque));
  }

  void add(RayObjects& ray, const Hit& hit, bool visible) const {
    const uint32_t object = object_of(hit.instance);
    if (object == ObjectTruthRequest::no_object) return;
    for (RayObjects::Met& met : ray.met)
      if (met.object == object) {
        met.visible |= visible;
        return;
      }
    ray.met.push_back({object, visible});
  }

  uint32_t object_of(uint32_t instance) const {
    return instance < request_.object_of.size() ? request_.object_of[instance] : ObjectTruthRequest::no_object;
  }

  const ObjectTruthRequest& request_;
  SurfaceWalk walk_;
  std::vector<RayObjects> objects_;
};

// Returns the view with the pixels' centres moved to `place` in each pixel: (0.5, 0.5) is the middle.
TraceView moved(const TraceView& view, glm::dvec2 place, uint32_t width, uint32_t height) {
  const glm::dvec3 shift((1.0 - 2.0 * place.x) / width, (1.0 - 2.0 * place.y) / height, 0.0);
  TraceView result = view;
  result.clip_from_local = glm::translate(glm::dmat4(1.0), shift) * view.clip_from_local;
  result.local_from_clip = view.local_from_clip * glm::translate(glm::dmat4(1.0), -shift);
  return result;
}

// Traces one sample position of all pixels.
class PlacePass {
 public:
  PlacePass(const ObjectTruthRequest& request, TracedScene& scene, const FramePixels& frame)
      : request_(request), scene_(scene), frame_(frame) {}

  // Calls take(pixel, objects, thread, chunk) for every pixel; chunks come in any order.
  template <typename TakeObjects>
  void trace(glm::dvec2 place, const TakeObjects& take) {
    const ViewRays view(moved(request_.view, place, request_.width, request_.height), request_.width, request_.height);
    const model::Snapshot& snapshot = *scene_.shading().snapshot;
    scene_.executor().run(chunks(), [&](size_t chunk, uint32_t thread) {
      const size_t first = chunk * pixels_in_object_chunk;
      const std::span<const PixelRequest> pixels = std::span<const PixelRequest>(frame_.pixels)
          .subspan(first, std::min(pixels_in_object_chunk, frame_.pixels.size() - first));
      std::vector<Ray> rays;
      for (const PixelRequest& p : pixels) rays.push_back(view.ray(p.x, p.y));
      ObjectRays tracer(request_, snapshot, scene_.intersector(), view.alpha_cone());
      const std::span<const RayObjects> objects = tracer.trace(rays);
      for (size_t i = 0; i < pixels.size(); ++i) take(pixels[i], objects[i], thread, chunk);
    });
  }

  size_t chunks() const { return (frame_.pixels.size() + pixels_in_object_chunk - 1) / pixels_in_object_chunk; }

 private:
  const ObjectTruthRequest& request_;
  TracedScene& scene_;
  const FramePixels& frame_;
};

// Builds a mask from pixels given column by column.
class MaskBuilder {
 public:
  explicit MaskBuilder(ObjectMask& mask) : mask_(mask) {}
  void add(uint32_t x, uint32_t y, uint32_t height) {
    const uint64_t at = uint64_t{x} * height + y;
    if (mask_.pixels == 0 || at != end_) {
      mask_.runs.push_back(static_cast<uint32_t>(at - end_));
      mask_.runs.push_back(0);
    }
    ++mask_.runs.back();
    end_ = at + 1;
    low_ = mask_.pixels == 0 ? glm::uvec2(x, y) : glm::min(low_, glm::uvec2(x, y));
    high_ = glm::max(high_, glm::uvec2(x, y));
    ++mask_.pixels;
  }
  void end(uint64_t pixels) {
    if (end_ < pixels || mask_.runs.empty()) mask_.runs.push_back(static_cast<uint32_t>(pixels - end_));
    if (mask_.pixels > 0) mask_.corner = low_, mask_.size = high_ - low_ + 1u;
  }

 private:
  ObjectMask& mask_;
  uint64_t end_ = 0;
  glm::uvec2 low_{0}, high_{0};
};

void make_masks(std::vector<Covered>& covered, const ObjectTruthRequest& request, std::vector<ObjectTruth>& truths) {
  std::sort(covered.begin(), covered.end(), [](const Covered& a, const Covered& b) {
    return a.object != b.object ? a.object < b.object : a.x != b.x ? a.x < b.x : a.y < b.y;
  });
  size_t at = 0;
  for (uint32_t object = 0; object < request.objects; ++object) {
    MaskBuilder visible(truths[object].visible), amodal(truths[object].amodal);
    for (; at < covered.size() && covered[at].object == object; ++at) {
      amodal.add(covered[at].x, covered[at].y, request.height);
      if (covered[at].visible) visible.add(covered[at].x, covered[at].y, request.height);
    }
    visible.end(uint64_t{request.width} * request.height);
    amodal.end(uint64_t{request.width} * request.height);
  }
}

struct Samples {
  uint64_t visible = 0, amodal = 0;
};

void count_samples(PlacePass& pass, const ObjectTruthRequest& request, uint32_t threads,
                   std::vector<ObjectTruth>& truths) {
  std::vector<std::vector<Samples>> sums(threads, std::vector<Samples>(request.objects));
  const uint32_t n = request.samples_per_side;
  for (uint32_t k = 0; k < n * n; ++k)
    pass.trace((glm::dvec2(k % n, k / n) + 0.5) / static_cast<double>(n),
               [&](const PixelRequest&, const RayObjects& objects, uint32_t thread, size_t) {
                 for (const RayObjects::Met& met : objects.met) {
                   ++sums[thread][met.object].amodal;
                   sums[thread][met.object].visible += met.visible;
                 }
               });
  for (const std::vector<Samples>& of_thread : sums)
    for (uint32_t object = 0; object < request.objects; ++object) {
      truths[object].amodal_samples += of_thread[object].amodal;
      truths[object].visible_samples += of_thread[object].visible;
    }
}

}  // namespace

std::vector<ObjectTruth> trace_object_truth(const ObjectTruthRequest& request, TracedScene& scene) {
  const FramePixels frame = every_pixel(request.width, request.height, scene.executor());
  std::vector<ObjectTruth> truths(request.objects);
  PlacePass pass(request, scene, frame);
  std::vector<std::vector<Covered>> of_chunk(pass.chunks());
  pass.trace({0.5, 0.5}, [&](const PixelRequest& p, const RayObjects& objects, uint32_t, size_t chunk) {
    for (const RayObjects::Met& met : objects.met)
      of_chunk[chunk].push_back({met.object, p.x, request.height - 1 - p.y, met.visible});
  });
  std::vector<Covered> covered;
  for (const std::vector<Covered>& part : of_chunk) covered.insert(covered.end(), part.begin(), part.end());
  make_masks(covered, request, truths);
  if (request.samples_per_side == 1)  // the pixels' centres are the only samples
    for (ObjectTruth& truth : truths)
      truth.visible_samples = truth.visible.pixels, truth.amodal_samples = truth.amodal.pixels;
  else
    count_samples(pass, request, scene.executor().threads(), truths);
  return truths;
}

}  // namespace sideray::rt
