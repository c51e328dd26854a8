#include "bridge/plan/frame_plan.h"

#include <algorithm>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint64_t most_pixels = uint64_t{1} << 26;
constexpr uint32_t most_light_samples = 1u << 20;
// Of opaque surfaces that rays mirror; from two thirds of it on the prefiltered environment takes over.
constexpr float most_mirrored_roughness = 0.5f;
constexpr size_t most_masks = 32;

void check_picture(const sideray_render_options& o) {
  if (o.width < 1 || o.height < 1 || o.width > 16384 || o.height > 16384 || uint64_t{o.width} * o.height > most_pixels)
    fail(SIDERAY_INVALID_ARGUMENT, "picture of {}x{}: sides must be 1 to 16384 and at most {} pixels in all", o.width,
         o.height, most_pixels);
  if (o.samples < 1 || o.samples > 4096) fail(SIDERAY_INVALID_ARGUMENT, "samples {}: give 1 to 4096", o.samples);
  if (!(o.deadline_ms >= 0.0f) || !std::isfinite(o.deadline_ms))
    fail(SIDERAY_INVALID_ARGUMENT, "deadline_ms {}: give finite milliseconds, or 0 for none", o.deadline_ms);
  if (o.repeats > 10000) fail(SIDERAY_INVALID_ARGUMENT, "repeats {}: give 0 to 10000", o.repeats);
}

void check_reference(const sideray_render_options& o) {
  const bool sampled = o.reference || o.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
  if (sampled && (o.light_samples < 1 || o.light_samples > most_light_samples))
    fail(SIDERAY_INVALID_ARGUMENT, "light_samples {}: give 1 to {}", o.light_samples, most_light_samples);
  if (o.reference && (o.aovs & (SIDERAY_AOV_MASK | SIDERAY_AOV_LAYERS)))
    fail(SIDERAY_INVALID_ARGUMENT, "reference: has no mask and no layers to show; leave SIDERAY_AOV_{} out",
         o.aovs & SIDERAY_AOV_MASK ? "MASK" : "LAYERS");
}

void check_shadows(const sideray_render_options& o) {
  if (o.shadows < SIDERAY_SHADOWS_OFF || o.shadows > SIDERAY_SHADOWS_INEXACT)
    fail(SIDERAY_INVALID_ARGUMENT, "shadows {}: give a sideray_shadows", static_cast<int>(o.shadows));
  if (o.inexact < SIDERAY_EXACT || o.inexact > SIDERAY_INEXACT_ORIGIN)
    fail(SIDERAY_INVALID_ARGUMENT, "inexact {}: give a sideray_inexact", static_cast<int>(o.inexact));
  if (o.inexact_target < SIDERAY_TARGET_MODEL || o.inexact_target > SIDERAY_TARGET_STENCIL)
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_target {}: give a sideray_inexact_target",
         static_cast<int>(o.inexact_target));
  if (o.foliage < SIDERAY_FOLIAGE_STATIC || o.foliage > SIDERAY_FOLIAGE_UNIQUE)
    fail(SIDERAY_INVALID_ARGUMENT, "foliage {}: give a sideray_foliage", static_cast<int>(o.foliage));
  if (o.shared_copies < 1 || o.shared_copies > 256)
    fail(SIDERAY_INVALID_ARGUMENT, "shared_copies {}: give 1 to 256", o.shared_copies);
  if (!(o.cull_angle_deg >= 0.0f && o.cull_angle_deg <= 90.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "cull_angle_deg {}: give 0 to 90", o.cull_angle_deg);
  if (!(o.inexact_bias >= 0.0f && std::isfinite(o.inexact_bias)))
    fail(SIDERAY_INVALID_ARGUMENT, "inexact_bias {}: give a finite length of 0 or more", o.inexact_bias);
  if (o.denoise_on < SIDERAY_DENOISE_AUTO || o.denoise_on > SIDERAY_DENOISE_GPU)
    fail(SIDERAY_INVALID_ARGUMENT, "denoise_on {}: give a sideray_denoise_on", static_cast<int>(o.denoise_on));
}

void check_translucency(const sideray_render_options& o) {
  if (o.translucency < SIDERAY_TRANSLUCENCY_OFF || o.translucency > SIDERAY_TRANSLUCENCY_REFERENCE)
    fail(SIDERAY_INVALID_ARGUMENT, "translucency {}: give a sideray_translucency", static_cast<int>(o.translucency));
  if (o.translucency == SIDERAY_TRANSLUCENCY_HYBRID && o.layers > 8)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: hybrid translucency takes 0 to 8", o.layers);
  if (o.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED && o.layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: ray-traced translucency takes 1 to 64, or 0 for unlimited", o.layers);
  if (o.check && o.translucency != SIDERAY_TRANSLUCENCY_HYBRID)
    fail(SIDERAY_INVALID_ARGUMENT, "check: only hybrid translucency has layers to check; choose it or leave check out");
  if (o.radiance_format < SIDERAY_RADIANCE_RGBA16F || o.radiance_format > SIDERAY_RADIANCE_RGB9E5)
    fail(SIDERAY_INVALID_ARGUMENT, "radiance_format {}: give a sideray_radiance_format",
         static_cast<int>(o.radiance_format));
  if (o.oit < SIDERAY_OIT_SORTED || o.oit > SIDERAY_OIT_PEEL)
    fail(SIDERAY_INVALID_ARGUMENT, "oit {}: give a sideray_oit", static_cast<int>(o.oit));
  if (o.mask < SIDERAY_NO_MASK || o.mask > SIDERAY_COUNT_MASK)
    fail(SIDERAY_INVALID_ARGUMENT, "mask {}: give a sideray_mask", static_cast<int>(o.mask));
  if (o.match < SIDERAY_MATCH_ID || o.match > SIDERAY_MATCH_DISTANCE)
    fail(SIDERAY_INVALID_ARGUMENT, "match {}: give a sideray_match", static_cast<int>(o.match));
  if (o.step < SIDERAY_STEP_MULTIHIT || o.step > SIDERAY_STEP_LISTING)
    fail(SIDERAY_INVALID_ARGUMENT, "step {}: give a sideray_step", static_cast<int>(o.step));
  if (!(o.match_threshold > 0.0f && o.match_threshold <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "match_threshold {}: give a share of the distance, above 0 and at most 1",
         o.match_threshold);
}

void check_layer_threshold(const sideray_render_options& o) {
  if (!(o.layer_threshold >= 0.0f) || !std::isfinite(o.layer_threshold))
    fail(SIDERAY_INVALID_ARGUMENT, "layer_threshold {}: give a finite radiance of 0 or more", o.layer_threshold);
  if (o.layer_threshold == 0.0f || o.reference) return;
  const bool hybrid = o.translucency == SIDERAY_TRANSLUCENCY_HYBRID;
  if (hybrid && (o.oit == SIDERAY_OIT_WEIGHTED || o.oit == SIDERAY_OIT_FRONT))
    fail(SIDERAY_INVALID_ARGUMENT,
         "layer_threshold {}: weighted blending bounds no surface's share of the picture; choose another oit or 0",
         o.layer_threshold);
  if (o.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED && o.refraction)
    fail(SIDERAY_INVALID_ARGUMENT, "layer_threshold {}: bent rays are all traced; leave it or refraction out",
         o.layer_threshold);
}

sideray_mask_source mask_source(const FramePlan& plan) {
  if (!plan.masks) return SIDERAY_MASK_NONE;
  return plan.mask_kind == gl::MaskKind::count ? SIDERAY_MASK_COUNT : SIDERAY_MASK_STENCIL;
}

bool is_traced(const model::Snapshot& snapshot, const model::Instance& instance, gl::TracedSet set) {
  const model::Material& material = snapshot.materials[instance.material];
  if (set == gl::TracedSet::all_translucent) return material.translucent;
  return set == gl::TracedSet::visible_in_layers && material.traceable && instance.surface_id != 0 &&
         (instance.visibility & SIDERAY_VISIBLE_LAYERS);
}

// Two triangles that share an edge, in one plane: no ray meets both.
bool is_flat_quad(const model::Mesh& mesh) {
  if (mesh.triangles.size() != 2) return false;
  const glm::uvec3 a = mesh.triangles[0], b = mesh.triangles[1];
  const auto& p = mesh.positions;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (a[i] != b[(j + 1) % 3] || a[(i + 1) % 3] != b[j]) continue;
      const glm::vec3 normal = glm::cross(p[a.y] - p[a.x], p[a.z] - p[a.x]);
      const glm::vec3 other = glm::cross(p[b.y] - p[b.x], p[b.z] - p[b.x]);
      return glm::dot(normal, p[b[(j + 2) % 3]] - p[a.x]) == 0.0f && glm::dot(normal, other) > 0.0f;
    }
  return false;
}

// Bits of the lights that masks are for. A light that sends nothing needs none, but where its mask is to be shown.
uint32_t masked_lights(const model::Snapshot& snapshot, const sideray_render_options& o) {
  const bool shown = (o.aovs & (SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE)) != 0;
  uint32_t bits = 0;
  for (size_t i = 0; i < std::min(snapshot.lights.size(), most_masks); ++i)
    if (shown || is_lit(snapshot.lights[i])) bits |= 1u << i;
  return bits;
}

// Raster translucent surfaces always take shadow maps, and so do lights beyond those that masks are for.
void plan_occlusion(const model::Snapshot& snapshot, const sideray_render_options& o, FramePlan& plan) {
  const auto any_lit = [&](size_t first) {
    return snapshot.lights.size() > first &&
           std::any_of(snapshot.lights.begin() + static_cast<ptrdiff_t>(first), snapshot.lights.end(), is_lit);
  };
  const bool by_rays = o.shadows == SIDERAY_SHADOWS_EXACT || o.shadows == SIDERAY_SHADOWS_INEXACT;
  if (by_rays) plan.shadow_lights = masked_lights(snapshot, o);
  plan.ao_rays = o.ao ? 4 : 0;
  plan.reflections = o.reflections != 0;
  plan.marks_inexact = o.shadows == SIDERAY_SHADOWS_INEXACT && plan.masks_occlusion() &&
                       std::any_of(snapshot.instances.begin(), snapshot.instances.end(), [&](const model::Instance& i) {
                         return gl::takes_inexact(snapshot.materials[i.material], i.wind, o.inexact_target);
                       });
  plan.fills_rest =
      plan.marks_inexact && (o.inexact == SIDERAY_INEXACT_RESTPOSE || o.inexact == SIDERAY_INEXACT_BOUNDED);
  const bool on_opaque = by_rays ? any_lit(most_masks) : any_lit(0);
  plan.shadow_maps = o.shadows != SIDERAY_SHADOWS_OFF && (on_opaque || (plan.rasters_translucency && any_lit(0)));
}

}  // namespace

void check_options(const sideray_render_options& o) {
  check_picture(o);
  check_translucency(o);
  check_layer_threshold(o);
  check_shadows(o);
  check_reference(o);
}

bool has_sprites(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.particles.begin(), snapshot.particles.end(),
                     [](const model::ParticleSystem& system) { return !system.sprites.empty(); });
}

uint64_t most_surfaces(const model::Snapshot& snapshot, gl::TracedSet traced, uint64_t enough) {
  uint64_t surfaces = 0;
  for (const model::Instance& instance : snapshot.instances) {
    if (surfaces >= enough) return enough;
    if (!is_traced(snapshot, instance, traced)) continue;
    const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
    surfaces += instance.wind == 0 && is_flat_quad(mesh) ? 1 : mesh.triangles.size();
  }
  return std::min(surfaces, enough);
}

FramePlan plan_frame(const model::Snapshot& snapshot, const sideray_render_options& o) {
  const auto any = [&](gl::TracedSet set) {
    return std::any_of(snapshot.instances.begin(), snapshot.instances.end(),
                       [&](const model::Instance& i) { return is_traced(snapshot, i, set); });
  };
  FramePlan plan{};
  plan.reference = o.reference != 0;
  plan.light_samples = o.light_samples;
  // Every instance as it is drawn.
  plan.foliage = {.mode = SIDERAY_FOLIAGE_UNIQUE,
                  .shared_copies = 1,
                  .unique_cap = 0,
                  .cull_angle_deg = 0.0f,
                  .eye = {},
                  .cull = {}};
  if (plan.reference) return plan;
  const bool exact = o.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
  const bool raytraced = exact || o.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED;
  const bool hybrid = o.translucency == SIDERAY_TRANSLUCENCY_HYBRID && o.layers > 0;
  plan.traced = raytraced ? gl::TracedSet::all_translucent : gl::TracedSet::visible_in_layers;
  plan.particles = (exact || (raytraced && o.rt_particles)) && has_sprites(snapshot);
  plan.drops_particles = raytraced && !plan.particles && has_sprites(snapshot);
  plan.traces = ((raytraced || hybrid) && any(plan.traced)) || plan.particles;
  if (!plan.traces) plan.traced = gl::TracedSet::none;
  plan.masks = plan.traces && !exact && o.mask != SIDERAY_NO_MASK;
  // Sprites are in no count: the mask only says where rays start.
  plan.mask_kind = o.mask == SIDERAY_COUNT_MASK && !plan.particles ? gl::MaskKind::count : gl::MaskKind::stencil;
  plan.rasters_translucency = !raytraced && o.translucency != SIDERAY_TRANSLUCENCY_OFF &&
                              (any(gl::TracedSet::all_translucent) || has_sprites(snapshot));
  plan_occlusion(snapshot, o, plan);
  if (!exact)
    plan.foliage = {.mode = o.foliage,
                    .shared_copies = o.shared_copies,
                    .unique_cap = o.unique_cap,
                    .cull_angle_deg = o.cull_angle_deg,
                    .eye = {},
                    .cull = {.keeps_translucent = raytraced, .remembers = o.continues != 0}};
  plan.distorts = o.translucency != SIDERAY_TRANSLUCENCY_OFF &&
                  std::any_of(snapshot.instances.begin(), snapshot.instances.end(), [&](const model::Instance& i) {
                    const model::Material& material = snapshot.materials[i.material];
                    return material.translucent && material.desc.distortion > 0.0f;
                  });
  plan.second_wave = hybrid && plan.traces && o.second_wave != 0 &&
                     (o.cache_rate == SIDERAY_RATE_CHECKERBOARD || o.cache_rate == SIDERAY_RATE_INTERLEAVED ||
                      o.cache_rate == SIDERAY_RATE_QUARTER);
  plan.mode = raytraced ? SIDERAY_COMPOSITE : SIDERAY_CACHE;
  plan.layers = exact ? 0 : o.layers;
  // Layers that are to be shown are as many as were asked for, and so are those that have to be as many as fragments
  // are put in order, which other surfaces have a part in too.
  if (hybrid && plan.traces && !(o.aovs & SIDERAY_AOV_LAYERS) && o.oit != SIDERAY_OIT_FRONT)
    plan.layers = static_cast<uint32_t>(std::max<uint64_t>(most_surfaces(snapshot, plan.traced, o.layers), 1));
  plan.light_samples = exact && plan.traces ? o.light_samples : 0;
  // Several positions are an average already.
  plan.averages = o.taa && o.samples == 1 && plan.light_samples == 0;
  plan.motion =
      (o.aovs & SIDERAY_AOV_MOTION) || (o.continues && (plan.averages || (o.denoise && plan.masks_occlusion())));
  return plan;
}

sideray_frame_inputs frame_inputs(const FramePlan& plan, const sideray_render_options& o) {
  sideray_frame_inputs inputs = sideray_frame_defaults();
  inputs.mask = mask_source(plan);
  inputs.stencil_bits = gl::mask_stencil_bits;
  inputs.mode = plan.mode;
  inputs.max_layers = plan.layers;
  inputs.all_translucent = plan.traced == gl::TracedSet::all_translucent;
  inputs.shadows = o.shadows != SIDERAY_SHADOWS_OFF;
  inputs.step = o.step;
  inputs.match = o.match;
  inputs.match_threshold = o.match_threshold;
  inputs.cache_rate = o.cache_rate;
  inputs.continues = o.continues;
  inputs.radiance_format = o.radiance_format;
  inputs.denoise = o.denoise;
  if (plan.traces && plan.light_samples == 0) inputs.layer_threshold = o.layer_threshold;
  inputs.denoise_on = o.denoise_on;
  inputs.refraction = o.refraction;
  inputs.particles = plan.particles;
  inputs.layers_off = !plan.traces;
  inputs.shadow_lights = plan.shadow_lights;
  inputs.ao_rays = plan.ao_rays;
  inputs.reflection_max_roughness = most_mirrored_roughness;
  if (plan.marks_inexact) {
    inputs.inexact = o.inexact;
    inputs.inexact_bias = o.inexact_bias;
    inputs.inexact_bits = gl::inexact_stencil_bit;
  }
  inputs.deadline_ms = o.deadline_ms;
  inputs.seed = o.seed;
  return inputs;
}

}  // namespace sideray::bridge
