// The parts of Renderer that look at a drawn frame: additional outputs and measurements.
#include <fmt/format.h>
#include <half.h>

#include <cmath>
#include <cstring>

#include "bridge/renderer/renderer.h"
#include "rt/poses/particle_quads.h"

namespace sideray::bridge {
namespace {

// Planar distance along the view axis of each pixel's window depth; +inf where nothing was drawn.
std::vector<float> planar_distances(const std::vector<float>& depth, const gl::RasterView& view, uint32_t width,
                                    uint32_t height) {
  std::vector<float> z(depth.size());
  const glm::dvec4 eye_plane =
      glm::dvec4(glm::dvec3(view.view_from_local[0][2], view.view_from_local[1][2], view.view_from_local[2][2]),
                 view.view_from_local[3][2]);
  const float background = view.reversed_depth ? 0.0f : 1.0f;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t i = size_t{y} * width + x;
      if (depth[i] == background) {
        z[i] = INFINITY;
        continue;
      }
      const double clip_z = view.zero_to_one_depth ? double{depth[i]} : 2.0 * double{depth[i]} - 1.0;
      const glm::dvec4 p =
          view.local_from_clip * glm::dvec4((x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0, clip_z, 1.0);
      z[i] = static_cast<float>(-glm::dot(eye_plane, p / p.w));
    }
  return z;
}

void add_layers(Picture& picture, const rt::LayerCache& cache, uint32_t layers) {
  const size_t plane = size_t{cache.width} * cache.height;
  for (uint32_t k = 0; k < layers; ++k) {
    const std::string prefix = fmt::format("layer{}.", k);
    const uint16_t* halfs = cache.radiance.data() + 4 * plane * k;
    const char* const names[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c)
      add_plane(picture, prefix + names[c], [&](size_t i) {
        Imath::half value;
        value.setBits(halfs[4 * i + c]);
        return cache.distance[plane * k + i] > 0.0f ? static_cast<float>(value) : 0.0f;
      });
    add_plane(picture, prefix + "distance", [&](size_t i) { return cache.distance[plane * k + i]; });
    add_plane(picture, prefix + "surface",
              [&](size_t i) { return cache.distance[plane * k + i] > 0.0f ? cache.surface_id[plane * k + i] : 0u; });
  }
}

// As they are looked up, wherever they were filtered.
std::vector<uint8_t> read_shadows(const gl::Functions& gl, const Service& service, size_t bytes) {
  std::vector<uint8_t> lit(bytes);
  sideray_mask_outputs outputs{};
  if (!service.masks(0, outputs) || bytes == 0) return lit;
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, outputs.shadow_texture);
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED, GL_UNSIGNED_BYTE, lit.data());
  return lit;
}

// Channels are named by the number of the light; who knows its name puts that there.
void add_occlusion(Picture& picture, const gl::Functions& gl, const Service* service, const FramePlan& plan,
                   uint32_t aovs) {
  if (plan.shadow_lights == 0 || !service) return;
  const rt::OcclusionMasks& masks = service->mask_image();
  const size_t plane = size_t{masks.width} * masks.height;
  const std::vector<uint8_t> lit = read_shadows(gl, *service, aovs & SIDERAY_AOV_SHADOW ? masks.lit.size() : 0);
  for (uint32_t k = 0; k < masks.layers; ++k) {
    if (aovs & SIDERAY_AOV_SHADOW)
      add_plane(picture, fmt::format("shadow.{}", k),
                [&](size_t i) { return static_cast<float>(lit[plane * k + i]) / 255.0f; });
    if (aovs & SIDERAY_AOV_HIT_DISTANCE && !masks.hit_distance.empty())
      add_plane(picture, fmt::format("hitdist.{}", k), [&](size_t i) { return masks.hit_distance[plane * k + i]; });
  }
}

}  // namespace

void Renderer::add_aovs(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options,
                        Picture& picture) {
  const uint32_t aovs = options.aovs;
  if (aovs & SIDERAY_AOV_Z) {
    const std::vector<float> z = planar_distances(rasterizer_->read_depth(), view, options.width, options.height);
    add_plane(picture, "Z", [&](size_t i) { return z[i]; });
  }
  if (aovs & (SIDERAY_AOV_NORMAL | SIDERAY_AOV_ALBEDO | SIDERAY_AOV_MATERIAL | SIDERAY_AOV_ID)) {
    const gl::Rasterizer::GBufferImages g = rasterizer_->read_gbuffer();
    if (aovs & SIDERAY_AOV_NORMAL)
      add_vectors(picture, "N.", {"X", "Y", "Z"}, [&](size_t i) { return g.normal_roughness[i]; });
    if (aovs & SIDERAY_AOV_ALBEDO)
      add_vectors(picture, "albedo.", {"R", "G", "B"}, [&](size_t i) { return g.albedo_metallic[i]; });
    if (aovs & SIDERAY_AOV_MATERIAL) {
      add_plane(picture, "material.metallic", [&](size_t i) { return g.albedo_metallic[i].w; });
      add_plane(picture, "material.roughness", [&](size_t i) { return g.normal_roughness[i].w; });
    }
    if (aovs & SIDERAY_AOV_ID) {
      add_plane(picture, "id.surface", [&](size_t i) { return g.ids[i].x; });
      add_plane(picture, "id.primitive", [&](size_t i) { return g.ids[i].y; });
    }
  }
  if (aovs & (SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE))
    add_occlusion(picture, context_->functions(), service_.get(), plan, aovs);
  if (aovs & SIDERAY_AOV_MOTION) {
    const std::vector<glm::vec2> motion = rasterizer_->read_motion();
    add_plane(picture, "motion.X", [&](size_t i) { return motion[i].x; });
    add_plane(picture, "motion.Y", [&](size_t i) { return -motion[i].y; });  // down, as the rows of pictures
  }
  if (aovs & SIDERAY_AOV_INEXACT) {
    const std::vector<uint8_t> stencil = rasterizer_->read_stencil();
    const uint32_t bits = plan.marks_inexact ? gl::inexact_stencil_bit : 0;
    add_plane(picture, "mask.inexact", [&](size_t i) { return (stencil[i] & bits) != 0 ? 1u : 0u; });
  }
  if (aovs & SIDERAY_AOV_MASK) add_mask_count(plan, options, picture);
  if ((aovs & SIDERAY_AOV_LAYERS) && plan.traces && plan.mode == SIDERAY_CACHE)
    add_layers(picture, service_->cache(), plan.layers);
}

// A count whatever the frame itself needed: of the traced surfaces, or of all translucent ones where nothing is traced
// by the mode's nature.
void Renderer::add_mask_count(const FramePlan& plan, const RenderOptions& options, Picture& picture) {
  if (!plan.masks || plan.mask_kind != gl::MaskKind::count) {
    const bool traces_by_nature = options.translucency.method == SIDERAY_TRANSLUCENCY_HYBRID;
    rasterizer_->gbuffer();  // clears the stencil
    rasterizer_->mask(gl::MaskKind::count, plan.traces        ? plan.traced
                                           : traces_by_nature ? gl::TracedSet::visible_in_layers
                                                              : gl::TracedSet::all_translucent);
  }
  const std::vector<uint8_t> stencil = rasterizer_->read_stencil();
  add_plane(picture, "mask.count", [&](size_t i) { return static_cast<uint32_t>(stencil[i] & gl::mask_stencil_bits); });
}

void Renderer::measure(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                       Picture& picture) {
  std::vector<gl::RasterView> views;
  for (uint32_t sample = 0; sample < options.samples; ++sample)
    views.push_back(rasterizer_->make_view(camera, jitter(plan, options, sample)));
  const gl::Functions& gl = context_->functions();
  std::vector<double> times[stage_count];
  for (uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
    FrameTimer staged(gl, FrameTimer::Mode::staged);
    for (const gl::RasterView& view : views) draw_frame(plan, view, options, staged, false);
    for (int stage = 0; stage < SIDERAY_STAGE_TOTAL_FRAME; ++stage)
      times[stage].push_back(staged.ms(static_cast<sideray_stage>(stage)));
    FrameTimer whole(gl, FrameTimer::Mode::off), total(gl, FrameTimer::Mode::staged);
    total.stage(SIDERAY_STAGE_TOTAL_FRAME, [&] {
      for (const gl::RasterView& view : views) draw_frame(plan, view, options, whole, false);
    });
    times[SIDERAY_STAGE_TOTAL_FRAME].push_back(total.ms(SIDERAY_STAGE_TOTAL_FRAME));
  }
  for (size_t stage = SIDERAY_STAGE_GBUFFER; stage < stage_count; ++stage)
    picture.stages.set(static_cast<sideray_stage>(stage), std::move(times[stage]));
  picture.stats.repeats = options.repeats;
  count(plan, views, options, picture);
}

void Renderer::add_counters(const FrameResult& frame, sideray_render_stats& stats) {
  const rt::Counters& t = frame.trace;
  stats.rays_primary += t.rays_primary;
  stats.rays_reflection += t.rays_reflection;
  stats.rays_shadow += t.rays_shadow;
  stats.rays_ao += t.rays_ao;
  stats.pixels_masked += t.pixels_masked;
  stats.pixels_late += t.pixels_late;
  stats.layers_requested += t.layers_requested, stats.layers_found += t.layers_found;
  stats.traversals_wasted += t.traversals_wasted;
  stats.rays_skipped += t.rays_skipped;
  stats.layers_skipped += t.layers_skipped;
  stats.layers_matched += frame.fragments.matched, stats.layers_missed += frame.fragments.missed;
  stats.layers_misassigned += frame.fragments.misassigned, stats.layers_duplicated += frame.duplicated;
  stats.bytes_readback += t.bytes_readback, stats.bytes_upload += t.bytes_upload;
  stats.bytes_cache = t.bytes_cache;
}

void Renderer::count(const FramePlan& plan, const std::vector<gl::RasterView>& views,
                     const RenderOptions& options, Picture& picture) {
  sideray_render_stats& stats = picture.stats;
  FrameTimer untimed(context_->functions(), FrameTimer::Mode::off);
  for (const gl::RasterView& view : views) {
    const FrameResult frame = draw_frame(plan, view, options, untimed, true);
    add_counters(frame, stats);
  }
  if (plan.drops_particles) {
    const gl::RasterView& v = views.front();
    stats.dropped_particles = rt::count_sprites_in_view(
        *snapshot_, {v.clip_from_local, v.local_from_clip, v.reversed_depth, v.zero_to_one_depth});
  }
  stats.pixels_total = uint64_t{options.width} * options.height * views.size();
  if (plan.uses_rays()) describe_tracer(stats);  // a tracer may be left from an earlier picture
}

void Renderer::describe_tracer(sideray_render_stats& stats) const {
  if (!tracer_) return;
  stats.threads = tracer_->tracer.threads();
  std::snprintf(stats.isa, sizeof(stats.isa), "%s", tracer_->tracer.isa().c_str());
  std::snprintf(stats.embree, sizeof(stats.embree), "%s", tracer_->tracer.embree().c_str());
}

}  // namespace sideray::bridge
