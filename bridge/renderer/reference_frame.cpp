#include "bridge/renderer/reference_frame.h"

#include "bridge/renderer/renderer.h"

namespace sideray::bridge {

double self_error(const std::vector<glm::vec4>& color, const std::vector<glm::vec3>& half_difference) {
  double sum = 0;
  for (size_t i = 0; i < color.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double mean = color[i][c], half = half_difference[i][c];
      const double reference = mean - half, difference = 2.0 * half;
      sum += difference * difference / (reference * reference + 0.01);
    }
  return color.empty() ? 0.0 : sum / (3.0 * static_cast<double>(color.size()));
}

void state_self_error(sideray_render_stats& stats, uint32_t light_samples, const std::vector<glm::vec4>& color,
                      const std::vector<glm::vec3>& half_difference) {
  stats.reference_light_samples = light_samples;
  stats.reference_self_error = light_samples > 1 ? self_error(color, half_difference) : -1.0;
}

// Pictures with reference translucency, timed as they are drawn: tracing takes so long that neither a frame before nor
// the fences between stages tell in it.
void Renderer::draw_timed(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                          Picture& picture) {
  std::vector<double> times[stage_count];
  for (uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
    Picture again;
    FrameTimer timer(context_->functions(), FrameTimer::Mode::staged);
    draw_picture(plan, camera, options, timer, repeat == 0 ? picture : again);
    double total = 0;
    for (int stage = 0; stage < SIDERAY_STAGE_TOTAL_FRAME; ++stage) {
      times[stage].push_back(timer.ms(static_cast<sideray_stage>(stage)));
      total += times[stage].back();
    }
    times[SIDERAY_STAGE_TOTAL_FRAME].push_back(total);
  }
  sideray_render_stats& stats = picture.stats;
  for (size_t stage = SIDERAY_STAGE_GBUFFER; stage < stage_count; ++stage)
    picture.stages.set(static_cast<sideray_stage>(stage), std::move(times[stage]));
  stats.repeats = options.repeats;
  stats.pixels_total = uint64_t{options.width} * options.height * options.samples;
  describe_tracer(stats);
}

// Timed as it is drawn, without a warm-up: it takes long enough, and nothing of it is kept from frame to frame.
void Renderer::draw_reference(const FramePlan& plan, const sideray_camera& camera,
                              const RenderOptions& options, Picture& picture) {
  std::vector<gl::RasterView> views;
  rt::ReferenceRequest request;
  for (uint32_t sample = 0; sample < options.samples; ++sample) {
    const gl::RasterView view = rasterizer_->make_view(camera, sample_jitter(sample, options.samples));
    request.views.push_back({view.clip_from_local, view.local_from_clip, view.reversed_depth, view.zero_to_one_depth});
    views.push_back(view);
  }
  request.width = options.width;
  request.height = options.height;
  request.light_samples = plan.light_samples;
  request.shadows = options.shadows.method != SIDERAY_SHADOWS_OFF;
  request.refraction = options.reference->refraction != 0;
  request.reflections = options.reflections;
  request.surfaces = options.aovs != 0;
  request.seed = options.seed;
  rt::ReferenceImage image;
  rt::Counters counters;
  std::vector<double> times;
  {
    const std::lock_guard lock(tracer_->turn);
    for (uint32_t repeat = 0; repeat < std::max(options.repeats, 1u); ++repeat) {
      const auto start = std::chrono::steady_clock::now();
      counters = tracer_->tracer.trace_reference(request, image);
      times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
  }
  add_color(picture, image.color);
  if (options.aovs != 0) add_reference_aovs(image, views.front(), options.aovs, picture);
  sideray_render_stats& stats = picture.stats;
  state_self_error(stats, plan.light_samples, image.color, image.half_difference);
  if (options.repeats == 0) return;
  stats.repeats = options.repeats;
  picture.stages.set(SIDERAY_STAGE_TRACE, times);
  picture.stages.set(SIDERAY_STAGE_TOTAL_FRAME, times);
  stats.rays_primary = counters.rays_primary;
  stats.rays_reflection = counters.rays_reflection, stats.rays_shadow = counters.rays_shadow;
  stats.pixels_total = counters.pixels_total, stats.pixels_masked = counters.pixels_masked;
  stats.layers_found = counters.layers_found, stats.traversals_wasted = counters.traversals_wasted;
  describe_tracer(stats);
}

void Renderer::add_reference_aovs(const rt::ReferenceImage& image, const gl::RasterView& view, uint32_t aovs,
                                  Picture& picture) const {
  const std::vector<rt::ReferenceSurface>& s = image.surfaces;
  const glm::dvec3 axis(view.view_from_local[0][2], view.view_from_local[1][2], view.view_from_local[2][2]);
  if (aovs & SIDERAY_AOV_Z)
    add_plane(picture, "Z", [&](size_t i) {
      const double z = -(glm::dot(axis, glm::dvec3(s[i].position)) + view.view_from_local[3][2]);
      return s[i].ids.y == 0 ? INFINITY : static_cast<float>(z);
    });
  if (aovs & SIDERAY_AOV_NORMAL) add_vectors(picture, "N.", {"X", "Y", "Z"}, [&](size_t i) { return s[i].normal; });
  if (aovs & SIDERAY_AOV_ALBEDO)
    add_vectors(picture, "albedo.", {"R", "G", "B"}, [&](size_t i) { return s[i].albedo; });
  if (aovs & SIDERAY_AOV_MATERIAL) {
    add_plane(picture, "material.metallic", [&](size_t i) { return s[i].metallic; });
    add_plane(picture, "material.roughness", [&](size_t i) { return s[i].roughness; });
  }
  if (aovs & SIDERAY_AOV_ID) {
    add_plane(picture, "id.surface", [&](size_t i) { return s[i].ids.x; });
    add_plane(picture, "id.primitive", [&](size_t i) { return s[i].ids.y; });
  }
}

}  // namespace sideray::bridge
