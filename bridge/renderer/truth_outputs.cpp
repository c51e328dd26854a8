#include "bridge/renderer/truth_outputs.h"

#include <mutex>

#include "rt/truth/ground_truth.h"

namespace sideray::bridge {
namespace {

rt::GroundTruthRequest truth_request(const PictureJob& job) {
  const gl::RasterView view = job.backend.make_view(job.camera, glm::vec2(0.0f));
  rt::GroundTruthRequest request;
  request.view = {view.clip_from_local, view.local_from_clip, view.reversed_depth, view.zero_to_one_depth};
  for (int c = 0; c < 4; ++c) request.depth_plane[c] = -view.view_from_local[c][2];
  request.width = job.plan.width;
  request.height = job.plan.height;
  request.behind = job.options.shows(SIDERAY_AOV_BEHIND | SIDERAY_AOV_REFRACTION);
  return request;
}

// Adds the planes of a surface: value(i) is that of texel i.
template <typename Value>
void add_surface(Picture& picture, const std::string& prefix, const Value& value) {
  add_plane(picture, prefix + "surface", [&](size_t i) { return value(i).surface; });
  add_plane(picture, prefix + "primitive", [&](size_t i) { return value(i).primitive; });
  add_plane(picture, prefix + "Z", [&](size_t i) { return value(i).z; });
  add_vectors(picture, (prefix + "N.").c_str(), {"X", "Y", "Z"}, [&](size_t i) { return value(i).normal; });
}

void add_behind(const std::vector<rt::PathTruth>& paths, Picture& picture) {
  add_surface(picture, "behind.", [&](size_t i) -> const rt::SeenSurface& { return paths[i].end; });
  add_plane(picture, "behind.length", [&](size_t i) { return paths[i].length; });
  add_plane(picture, "behind.turns", [&](size_t i) { return paths[i].turns; });
  add_plane(picture, "behind.state", [&](size_t i) { return static_cast<uint32_t>(paths[i].state); });
}

void add_refraction(const std::vector<rt::PathTruth>& paths, Picture& picture) {
  add_plane(picture, "refraction.X", [&](size_t i) { return paths[i].place.x; });
  add_plane(picture, "refraction.Y", [&](size_t i) { return paths[i].place.y; });
  add_plane(picture, "refraction.state", [&](size_t i) { return static_cast<uint32_t>(paths[i].seen); });
}

}  // namespace

void add_ground_truth(const PictureJob& job, Picture& picture) {
  if (!job.plan.ground_truth) return;
  rt::GroundTruthImage image;
  {
    const std::lock_guard lock(job.tracer->turn);
    image = job.tracer->tracer.trace_ground_truth(truth_request(job));
  }
  const RenderOptions& o = job.options;
  if (o.shows(SIDERAY_AOV_FIRST))
    add_surface(picture, "first.", [&](size_t i) -> const rt::SeenSurface& { return image.first[i]; });
  if (o.shows(SIDERAY_AOV_GLASS))
    add_surface(picture, "glass.", [&](size_t i) -> const rt::SeenSurface& { return image.glass[i]; });
  if (o.shows(SIDERAY_AOV_BEHIND)) add_behind(image.behind, picture);
  if (o.shows(SIDERAY_AOV_REFRACTION)) add_refraction(image.behind, picture);
}

}  // namespace sideray::bridge
