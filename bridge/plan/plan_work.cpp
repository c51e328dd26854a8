#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <tuple>

#include "bridge/jobs/layers/layer_textures.h"
#include "bridge/plan/plan_description.h"
#include "gl/scene/raster_scene.h"
#include "gl/scene/shadow_plan.h"
#include "gl/scene/tint_maps.h"
#include "rt/light/diffuse_paths.h"
#include "rt/masks/mask_filters.h"

namespace sideray::bridge {
namespace {

using Textures = std::vector<PlannedTexture>;

// A mirror ray is traced for opaque surfaces, for translucent ones in front of them, and again for those beyond the
// first few (rt/shading/hit_shader.cpp).
constexpr uint64_t rays_a_mirror = 3;
// One ray for each surface of a path, one to the sky, one for the glass before the sky.
constexpr uint64_t rays_a_path = rt::most_path_surfaces + 2;

// A sum with an unbounded term is unbounded.
uint64_t sum(uint64_t a, uint64_t b) {
  return a == SIDERAY_UNBOUNDED || b == SIDERAY_UNBOUNDED ? SIDERAY_UNBOUNDED : a + b;
}
uint64_t product(uint64_t a, uint64_t b) {
  return a == SIDERAY_UNBOUNDED || b == SIDERAY_UNBOUNDED ? SIDERAY_UNBOUNDED : a * b;
}

void add_targets(const model::Snapshot& snapshot, const FramePlan& plan, Textures& textures) {
  const auto add = [&](const char* name, const char* format, uint32_t layers, uint64_t texel_bytes) {
    if (layers > 0) textures.push_back({name, format, plan.width, plan.height, layers, texel_bytes});
  };
  uint32_t lobes = 0;
  for (const model::Instance& instance : snapshot.instances) {
    const model::Material& material = snapshot.materials[instance.material];
    if (!material.translucent) lobes |= gl::lobes_of(material.desc);
  }
  add("gbuffer", "RGBA16F", 4, 8);
  const auto lobe_targets = static_cast<uint32_t>(std::popcount(lobes & gl::lobe::in_targets));
  add("gbuffer.lobes", "RGBA16F", plan.reference ? 0 : lobe_targets, 8);
  const bool brushed = !plan.reference && (lobes & gl::lobe::anisotropy) != 0;
  add("gbuffer.ids", brushed ? "RGBA32UI" : "RG32UI", 1, brushed ? 16 : 8);
  add("depth_stencil", "DEPTH32F_STENCIL8", 1, 8);
  add("color", "RGBA32F", 1, 16);
  if (plan.reference) return;
  add("motion", "RG32F", plan.motion ? 1 : 0, 8);
  add("rest", "RGBA32F", plan.fills_rest ? 1 : 0, 16);
  add("distortion", "RGBA32F", plan.distorts ? 2 : 0, 16);
  add("average.picture", "RGBA16F", plan.averages ? 2 : 0, 8);
  add("average.state", "RG32F", plan.averages ? 2 : 0, 8);
  const bool soft = std::any_of(snapshot.particles.begin(), snapshot.particles.end(), [](const auto& system) {
    return !system.sprites.empty() && system.desc.soft_distance > 0.0f;
  });
  add("depth_copy", "DEPTH32F_STENCIL8", plan.rasters_translucency && soft ? 1 : 0, 8);
}

// Adds the textures that the order of blended fragments needs besides the picture.
void add_order(const RenderOptions& o, const FramePlan& plan, Textures& textures) {
  if (!plan.rasters_translucency) return;
  const auto add = [&](const char* name, const char* format, uint32_t layers, uint64_t texel_bytes) {
    if (layers > 0) textures.push_back({name, format, plan.width, plan.height, layers, texel_bytes});
  };
  const sideray_oit oit = o.translucency.oit;
  const uint32_t slices = oit == SIDERAY_OIT_PEEL ? 2 : 0;
  add("order.keys", "RG32UI", slices, 8);
  add("order.depth", "DEPTH32F_STENCIL8", slices, 8);
  if (oit != SIDERAY_OIT_ABUFFER) return;
  add("order.heads", "R32UI", 1, 4);
  textures.push_back({"order.count", "R32UI", 1, 1, 1, 4});
}

uint64_t texels_below(const std::vector<model::Texture::Level>& levels) {
  uint64_t texels = 0;
  for (size_t i = 1; i < levels.size(); ++i) texels += uint64_t{levels[i].width} * levels[i].height;
  return texels;
}

// Adds the scene's textures by format and size, each image once.
void add_scene(const model::Snapshot& snapshot, Textures& textures) {
  std::map<std::tuple<bool, uint32_t, uint32_t>, std::set<const model::Texture*>> images;
  for (const auto& texture : snapshot.textures)
    images[{texture->srgb, texture->levels[0].width, texture->levels[0].height}].insert(texture.get());
  for (const auto& [kind, equal] : images) {
    const auto& [srgb, width, height] = kind;
    textures.push_back({"scene.images", srgb ? "SRGB8_ALPHA8" : "RGBA8", width, height,
                        static_cast<uint32_t>(equal.size()), 4, false, texels_below((*equal.begin())->levels)});
  }
  if (!snapshot.environment) return;
  const std::vector<model::Environment::Image>& specular = snapshot.environment->specular;
  uint64_t smaller = 0;
  for (size_t i = 1; i < specular.size(); ++i) smaller += uint64_t{specular[i].width} * specular[i].height;
  textures.push_back({"scene.environment", "RGB16F", specular[0].width, specular[0].height, 1, 6, false, smaller});
  const model::Environment::Image& irradiance = snapshot.environment->irradiance;
  textures.push_back({"scene.irradiance", "RGB32F", irradiance.width, irradiance.height, 1, 12});
  constexpr uint32_t table = model::AlbedoTable::size;
  textures.push_back({"scene.albedo_terms", "RGB32F", table, table, 1, 12});
}

void add_shadow_maps(const model::Snapshot& snapshot, const FramePlan& plan, Textures& textures) {
  if (!plan.shadow_maps) return;
  const gl::ShadowPlan maps = gl::plan_shadow_maps(snapshot.lights, gl::shadow_casters(snapshot), {});
  const auto add = [&](const char* name, uint32_t side, uint32_t layers) {
    if (layers > 0) textures.push_back({name, "DEPTH_COMPONENT32F", side, side, layers, 4});
  };
  const auto add_tints = [&](const char* name, uint32_t side, uint32_t layers) {
    const uint32_t small = gl::TintMaps::side_of(side, layers);
    if (layers > 0) textures.push_back({name, "RGBA16F", small, small, layers, 8});
  };
  add("shadow_map.directional", maps.directional_size, maps.directional_layers);
  add("shadow_map.local", maps.local_size, maps.local_layers);
  const gl::TintedLights tinted = plan.tint_maps();
  if (tinted != gl::TintedLights::none)
    add_tints("tint_map.directional", maps.directional_size, maps.directional_layers);
  if (tinted == gl::TintedLights::all) add_tints("tint_map.local", maps.local_size, maps.local_layers);
}

void add_results(const FramePlan& plan, Textures& textures) {
  const auto add = [&](const char* name, const char* format, uint32_t layers, uint64_t texel_bytes) {
    if (layers > 0) textures.push_back({name, format, plan.width, plan.height, layers, texel_bytes, true});
  };
  if (plan.traces && plan.layers.mode == SIDERAY_CACHE) {
    add("layers.radiance", "RGBA16F", plan.layers.max_layers, half4.bytes);
    add("layers.distance", "R32F", plan.layers.max_layers, single.bytes);
    add("layers.surface", "R32UI", plan.layers.max_layers, id32.bytes);
    add("layers.whole_radiance", "RGBA16F", plan.layers.whole_pixels ? 1 : 0, half4.bytes);
    add("layers.whole_transmittance", "RGBA16F", plan.layers.whole_pixels ? 1 : 0, half4.bytes);
  } else if (plan.traces) {
    add("composite.radiance", "RGBA16F", 1, half4.bytes);
    add("composite.transmittance", "RGBA16F", 1, half4.bytes);
  }
  add("shadow_masks", "R8", plan.shadow_masks() + (plan.masks.unhidden_sky ? 1u : 0u), 1);
  // A light gets tint planes when one of its rays first passes through glass: this is the most there can be.
  add("shadow_tints", "R8", plan.glass_shadows ? 3 * plan.shadow_masks() : 0, 1);
  add("ambient_mask", "R8", plan.masks.ao_rays > 0 ? 1 : 0, 1);
  add("irradiance", "RGBA16F", plan.bounces ? 1 : 0, half4.bytes);
  add("reflections", "RGBA16F", plan.reflects ? 1 : 0, half4.bytes);
}

// Returns the traversals for the translucent surfaces of one pixel.
uint64_t traversals_a_pixel(const FramePlan& plan) {
  const sideray_layer_inputs& layers = plan.layers;
  if (layers.refraction || (layers.mode == SIDERAY_COMPOSITE && layers.max_layers == 0)) return SIDERAY_UNBOUNDED;
  // One traversal finds up to 8 surfaces. With more, each traversal finds at least one, and a last one finds none.
  return layers.step == SIDERAY_STEP_MULTIHIT && layers.max_layers <= 8 ? 1 : layers.max_layers + uint64_t{1};
}

// Adds the rays that shade surfaces and what each mirrors.
void add_shading(uint64_t surfaces, bool direct, const model::Snapshot& snapshot, const FramePlan& plan,
                 sideray_plan_work& work) {
  work.rays_reflection = sum(work.rays_reflection, product(surfaces, rays_a_mirror));
  const uint64_t lights = !plan.casts_shadows ? 0 : snapshot.lights.size();
  work.rays_shadow = sum(work.rays_shadow, product(surfaces, lights * (direct ? 2 : 1)));
  if (!plan.bounces) return;
  // A surface and what it mirrors may send a path each.
  const uint64_t paths = product(surfaces, direct ? 2 : 1);
  work.rays_bounce = sum(work.rays_bounce, product(paths, rays_a_path));
  if (plan.casts_shadows) work.rays_shadow = sum(work.rays_shadow, product(paths, rt::most_path_surfaces));
}

void add_layers(const model::Snapshot& snapshot, const FramePlan& plan, sideray_plan_work& work) {
  if (!plan.traces) return;
  const uint64_t pixels = uint64_t{plan.width} * plan.height;
  if (plan.layers.light_samples > 0) {
    work.rays_primary = work.rays_reflection = work.rays_shadow = SIDERAY_UNBOUNDED;
    return;
  }
  const bool unlimited = plan.layers.refraction || (plan.layers.mode == SIDERAY_COMPOSITE && (plan.layers.max_layers == 0 || plan.layers.particles));
  work.rays_primary = product(pixels, traversals_a_pixel(plan));
  add_shading(unlimited ? SIDERAY_UNBOUNDED : pixels * plan.layers.max_layers, true, snapshot, plan, work);
  if (plan.layers.mode == SIDERAY_COMPOSITE) return;
  const uint64_t surfaces = most_surfaces(snapshot, plan.traced, most_counted_surfaces);
  work.fragments = surfaces < most_counted_surfaces ? pixels * surfaces : SIDERAY_UNBOUNDED;
}

// Adds the rays of a mask, and those at a quarter of the pixels that measure occluder distances for its filter.
void add_masks(const model::Snapshot& snapshot, const RenderOptions& o, const FramePlan& plan,
               sideray_plan_work& work) {
  const uint64_t pixels = uint64_t{plan.width} * plan.height;
  const uint64_t measured = uint64_t{(plan.width + 1) / 2} * ((plan.height + 1) / 2);
  const bool random = plan.marks_inexact && rt::is_random(plan.masks.inexact, gl::inexact_stencil_bit);
  const bool all_distances = o.shows(SIDERAY_AOV_HIT_DISTANCE);
  const auto add = [&](bool filtered) {
    work.rays_shadow = sum(work.rays_shadow, pixels + (all_distances ? pixels : 0) + (filtered ? measured : 0));
  };
  for (uint32_t bits = plan.masks.shadow_lights; bits != 0; bits &= bits - 1)
    add(plan.masks.denoise && rt::is_filtered(snapshot.lights[static_cast<size_t>(std::countr_zero(bits))], random));
  // The combined mask is always noisy, since each pixel's ray goes to a random light.
  if (plan.masks.combined_lights) add(plan.masks.denoise);
  work.rays_ao = plan.masks.ao_rays * (pixels + (plan.masks.denoise ? measured : 0));
}

// Adds bounced light: one pixel of four traces a path, which continues at each surface with a ray to a light there; and
// one ray to the sky, which may have to find translucent surfaces on its way.
void add_bounces(const FramePlan& plan, sideray_plan_work& work) {
  const uint64_t paths = uint64_t{(plan.width + 1) / 2} * ((plan.height + 1) / 2);
  work.rays_bounce = sum(work.rays_bounce, paths * (rays_a_path + 1));
  if (plan.casts_shadows) work.rays_shadow = sum(work.rays_shadow, paths * rt::most_path_surfaces);
}

void add_bytes(const RenderOptions& o, const FramePlan& plan, const Textures& textures, sideray_plan_work& work) {
  if (!plan.uses_rays()) return;
  const uint64_t pixels = uint64_t{plan.width} * plan.height;
  const uint64_t rest = plan.fills_rest ? 16 : 0;
  const uint64_t motion = plan.motion && plan.masks.denoise && o.picture.continues ? 8 : 0;
  work.bytes_readback = pixels * (8 + rest + motion + (plan.reflects ? 16 : 0));
  uint64_t layer_bytes = 0;
  for (const PlannedTexture& texture : textures) {
    if (!texture.of_service) continue;
    work.bytes_cache += texture.bytes();
    if (texture.name.starts_with("layers.")) layer_bytes += texture.bytes();
  }
  work.bytes_upload = work.bytes_cache;
  if (!plan.second_wave) return;
  work.bytes_readback += pixels * (8 + rest + motion);
  work.bytes_upload += layer_bytes;
}

// Adds the rays that find opaque surfaces, shadow rays of lights without a mask, and the rays of blended surfaces.
// Sprites are lit separately. Layers that are only shown are not counted.
void add_drawing(const model::Snapshot& snapshot, const FramePlan& plan, sideray_plan_work& work) {
  const uint64_t pixels = uint64_t{plan.width} * plan.height;
  work.rays_primary = sum(work.rays_primary, pixels);
  if (plan.casts_shadows && !plan.masks_shadows())
    work.rays_shadow = sum(work.rays_shadow, product(pixels, 2 * snapshot.lights.size()));
  if (plan.layers.particles) work.rays_shadow = SIDERAY_UNBOUNDED;
  if (!plan.rasters_translucency) return;
  work.rays_primary = SIDERAY_UNBOUNDED;
  if (plan.casts_shadows && !snapshot.lights.empty()) work.rays_shadow = SIDERAY_UNBOUNDED;
}

}  // namespace

Textures planned_textures(const model::Snapshot& snapshot, const RenderOptions& options, const FramePlan& plan) {
  if (plan.draws_by_rays()) return {};
  Textures textures;
  add_targets(snapshot, plan, textures);
  add_scene(snapshot, textures);
  if (plan.reference) return textures;
  add_order(options, plan, textures);
  add_shadow_maps(snapshot, plan, textures);
  add_results(plan, textures);
  return textures;
}

sideray_plan_work planned_work(const model::Snapshot& snapshot, const RenderOptions& o, const FramePlan& plan,
                               const Textures& textures) {
  sideray_plan_work work{};
  if (plan.reference) {
    work.rays_primary = work.rays_reflection = work.rays_shadow = SIDERAY_UNBOUNDED;
    return work;
  }
  add_layers(snapshot, plan, work);
  add_masks(snapshot, o, plan, work);
  if (plan.bounces) add_bounces(plan, work);
  if (plan.reflects) add_shading(uint64_t{plan.width} * plan.height, false, snapshot, plan, work);
  if (plan.draws_by_rays())
    add_drawing(snapshot, plan, work);
  else
    add_bytes(o, plan, textures, work);
  // Counts one frame for each camera position; their textures are shared.
  for (uint64_t* count : {&work.rays_primary, &work.rays_reflection, &work.rays_shadow, &work.rays_ao, &work.rays_bounce, &work.fragments,
                          &work.bytes_readback, &work.bytes_upload})
    *count = product(*count, plan.samples);
  return work;
}

}  // namespace sideray::bridge
