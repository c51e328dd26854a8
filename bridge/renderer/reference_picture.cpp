#include "bridge/renderer/reference_picture.h"

#include <algorithm>

#include "bridge/picture/self_error.h"
#include "bridge/renderer/measurement.h"
#include "bridge/renderer/truth_outputs.h"
#include "bridge/drawing/views.h"
#include "model/stopwatch.h"

namespace sideray::bridge {
namespace {

rt::ReferenceRequest request_of(const PictureJob& job, const std::vector<gl::RasterView>& views) {
  const RenderOptions& o = job.options;
  rt::ReferenceRequest request;
  for (const gl::RasterView& view : views)
    request.views.push_back({view.clip_from_local, view.local_from_clip, view.reversed_depth, view.zero_to_one_depth});
  request.width = job.plan.width;
  request.height = job.plan.height;
  request.light_samples = job.plan.layers.light_samples;
  request.bounces = job.plan.layers.bounces;
  request.caustics = job.plan.caustics;
  request.shadows = job.plan.casts_shadows;
  request.refraction = job.plan.layers.refraction != 0;
  request.reflections = job.plan.reflects;
  request.surfaces = o.picture.aovs != 0;
  request.seed = job.plan.seed;
  request.cancelled = &job.cancelled;
  return request;
}

void state_reference_counters(const rt::Counters& counters, sideray_render_stats& stats) {
  stats.rays_primary = counters.rays_primary;
  stats.rays_reflection = counters.rays_reflection;
  stats.rays_shadow = counters.rays_shadow;
  stats.pixels_total = counters.pixels_total;
  stats.pixels_masked = counters.pixels_masked;
  stats.layers_found = counters.layers_found;
  stats.traversals_wasted = counters.traversals_wasted;
}

void add_reference_aovs(const rt::ReferenceImage& image, const gl::RasterView& view, const RenderOptions& o,
                        Picture& picture) {
  const std::vector<rt::ReferenceSurface>& s = image.surfaces;
  const glm::dvec3 axis(view.view_from_local[0][2], view.view_from_local[1][2], view.view_from_local[2][2]);
  if (o.shows(SIDERAY_AOV_Z))
    add_plane(picture, "Z", [&](size_t i) {
      const double z = -(glm::dot(axis, glm::dvec3(s[i].position)) + view.view_from_local[3][2]);
      return s[i].ids.y == 0 ? INFINITY : static_cast<float>(z);
    });
  if (o.shows(SIDERAY_AOV_NORMAL)) add_vectors(picture, "N.", {"X", "Y", "Z"}, [&](size_t i) { return s[i].normal; });
  if (o.shows(SIDERAY_AOV_ALBEDO))
    add_vectors(picture, "albedo.", {"R", "G", "B"}, [&](size_t i) { return s[i].albedo; });
  if (o.shows(SIDERAY_AOV_MATERIAL)) {
    add_plane(picture, "material.metallic", [&](size_t i) { return s[i].metallic; });
    add_plane(picture, "material.roughness", [&](size_t i) { return s[i].roughness; });
  }
  if (o.shows(SIDERAY_AOV_ID)) {
    add_plane(picture, "id.surface", [&](size_t i) { return s[i].ids.x; });
    add_plane(picture, "id.primitive", [&](size_t i) { return s[i].ids.y; });
  }
}

}  // namespace

void draw_reference(const PictureJob& job, Picture& picture) {
  std::vector<gl::RasterView> views;
  for (uint32_t sample = 0; sample < job.plan.samples; ++sample)
    views.push_back(job.backend.make_view(job.camera, sample_jitter(sample, job.plan.samples)));
  const rt::ReferenceRequest request = request_of(job, views);
  rt::ReferenceImage image;
  rt::Counters counters;
  std::vector<double> times;
  {
    const std::lock_guard lock(job.tracer->turn);
    for (uint32_t repeat = 0; repeat < std::max(job.options.picture.repeats, 1u); ++repeat) {
      const Stopwatch watch;
      counters = job.tracer->tracer.trace_reference(request, image);
      job.require_wanted();
      times.push_back(watch.ms());
    }
  }
  add_color(picture, image.color);
  if (job.options.picture.aovs != 0) add_reference_aovs(image, views.front(), job.options, picture);
  add_ground_truth(job, picture);
  state_self_error(job.plan.layers.light_samples, job.plan.layers.bounces, image.color, image.half_difference, picture.stats);
  picture.stats.reference_caustics = job.plan.caustics;
  picture.stats.repeats = job.options.picture.repeats;
  picture.stages.set(SIDERAY_STAGE_TRACE, times);
  picture.stages.set(SIDERAY_STAGE_TOTAL_FRAME, times);
  state_reference_counters(counters, picture.stats);
  picture.stats.positions = job.plan.samples;
  describe_tracer(job, picture.stats);
  if (job.options.picture.repeats > 0) measure_raw_frame(job);
}

}  // namespace sideray::bridge
