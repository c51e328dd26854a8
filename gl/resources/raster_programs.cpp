#include "gl/resources/raster_programs.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/material_slots.h"

namespace sideray::gl {
namespace {

struct SamplerUnit {
  const char* name;
  uint32_t unit;
};

constexpr SamplerUnit sampler_units[] = {
    {"base_color_map", unit::material},
    {"sprite_map", unit::material},
    {"opaque_depth", unit::material + 1},
    {"metallic_roughness_map", unit::material + 1},
    {"normal_map", unit::material + 2},
    {"occlusion_map", unit::material + 3},
    {"emissive_map", unit::material + 4},
    {"transmission_map", unit::material + 5},
    {"thickness_map", unit::material + 6},
    {"specular_map", unit::material + 7},
    {"specular_color_map", unit::material + 8},
    {"clearcoat_map", unit::material + 9},
    {"clearcoat_roughness_map", unit::material + 10},
    {"clearcoat_normal_map", unit::material + 11},
    {"sheen_color_map", unit::material + 12},
    {"sheen_roughness_map", unit::material + 13},
    {"diffuse_transmission_map", unit::material + 14},
    {"diffuse_transmission_color_map", unit::material + 15},
    {"iridescence_map", unit::material + 16},
    {"iridescence_thickness_map", unit::material + 17},
    {"anisotropy_map", unit::material + 18},
    {"gbuffer_albedo_metallic", unit::material},
    {"gbuffer_normal_roughness", unit::material + 1},
    {"gbuffer_emissive_occlusion", unit::material + 2},
    {"gbuffer_specular", unit::material + 3},
    {"gbuffer_coat", unit::material + 4},
    {"gbuffer_sheen", unit::material + 5},
    {"gbuffer_behind", unit::material + 6},
    {"gbuffer_depth", unit::material + 7},
    {"gbuffer_ids", unit::material + 8},
    {"order_keys", unit::order_keys},
    {"opaque_levels", unit::opaque_levels},
    {"traced_radiance", unit::material},
    {"traced_transmittance", unit::material + 1},
    {"distortion_offsets", unit::material},
    {"opaque_picture", unit::material + 1},
    {"temporal_picture", unit::material},
    {"temporal_motion", unit::material + 1},
    {"history_picture", unit::material + 2},
    {"history_state", unit::material + 3},
    {"environment_specular", unit::environment_specular},
    {"environment_irradiance", unit::environment_irradiance},
    {"albedo_terms", unit::albedo_terms},
    {"directional_shadows", unit::directional_shadows},
    {"local_shadows", unit::local_shadows},
    {"directional_tints", unit::tint_maps},
    {"local_tints", unit::tint_maps + 1},
    {"light_texels", unit::many_lights},
    {"true_first", unit::material + 1},
    {"true_surfaces", unit::material + 2},
    {"shadow_masks", unit::layer_cache},
    {"shadow_tints", unit::material + 9},
    {"mask_answers", unit::material + 10},
    {"open_mask", unit::layer_cache + 1},
    {"mirrored", unit::layer_cache + 2},
    {"bounced", unit::material + 11},
    {"sideray_radiance", unit::layer_cache},
    {"sideray_distance", unit::layer_cache + 1},
    {"sideray_surface_id", unit::layer_cache + 2},
};

void bind_interface(const Program& program) {
  program.use();
  for (const SamplerUnit& s : sampler_units)
    if (program.uniform(s.name) >= 0) program.set(s.name, static_cast<int>(s.unit));
  program.set_block("Material", block::material);
  program.set_block("Lights", block::lights);
  program.set_block("Shadows", block::shadows);
}

constexpr const char* lists_version = "430 core";
constexpr const char* live_version = "450 core";  // has gl_HelperInvocation

constexpr uint32_t fixed_sets[] = {0x00, 0x01, 0x1f, 0x7f};

std::vector<std::string> shaded_defines(Shading shading) {
  return {"SR_SHADED", fmt::format("SR_MAPS {}", shading.maps), fmt::format("SR_LOBES {}", shading.lobes)};
}

const char* in_wind(bool wind) {
  return wind ? ", in wind" : "";
}

}  // namespace

uint32_t map_set_for(uint32_t maps, uint32_t scene_maps) {
  for (const uint32_t set : fixed_sets)
    if ((maps & ~set) == 0) return set;
  return scene_maps;
}

uint32_t available_maps(uint32_t texture_units) {
  const uint32_t slots = texture_units - std::min(texture_units, unit::material);
  return (1u << std::min<uint32_t>(slots, model::material_slot_count)) - 1;
}

const Program& RasterPrograms::get(const std::string& base_name, const Parts& parts) {
  const auto has_lights = [](const std::vector<std::string>& files) {
    return std::find(files.begin(), files.end(), "raster_lighting.glsl") != files.end();
  };
  const bool many_lights = many_lights_ && (has_lights(parts.vertices) || has_lights(parts.fragments));
  const std::string name = many_lights ? base_name + ", many lights" : base_name;
  const auto found = programs_.find(name);
  if (found != programs_.end()) return found->second;
  ShaderSpec vertex, fragment;
  vertex.files = parts.vertices;
  vertex.defines = parts.defines;
  if (many_lights) vertex.defines.emplace_back("SR_MANY_LIGHTS");
  fragment.defines = vertex.defines;
  fragment.files = parts.fragments;
  vertex.version = fragment.version = parts.version;
  Program program(gl_, name, vertex, fragment);
  bind_interface(program);
  return programs_.emplace(name, std::move(program)).first->second;
}

const Program& RasterPrograms::gbuffer(Shading shading, bool holes) {
  std::vector<std::string> defines = shaded_defines(shading);
  if (holes) defines.emplace_back("SR_HOLES");
  return get(
      fmt::format("G-buffer, textures {:#x}, lobes {}{}{}", shading.maps, shading.lobes, holes ? ", holes" : "",
                  in_wind(shading.wind)),
      surface(shading.wind, {"shading.h", "raster_material.glsl", "raster_gbuffer.frag.glsl"}, std::move(defines)));
}

RasterPrograms::Parts RasterPrograms::surface(bool wind, std::vector<std::string> fragments,
                                              std::vector<std::string> defines) {
  Parts parts{{"raster_surface.vert.glsl"}, std::move(fragments), std::move(defines)};
  if (wind) {
    parts.vertices.insert(parts.vertices.begin(), "wind.h");
    parts.defines.emplace_back("SR_WIND");
  }
  return parts;
}

// Adds `file`, which ends in emit_translucent, to the fragment shader of a surface that is drawn in `order`.
RasterPrograms::Parts RasterPrograms::ordered(Parts parts, FragmentOrder order, const char* file) {
  parts.defines.push_back(fmt::format("SR_ORDER {}", static_cast<uint32_t>(order)));
  if (order != FragmentOrder::blended) parts.fragments.push_back("raster_order_key.glsl");
  if (order == FragmentOrder::listed) {
    parts.fragments.push_back("raster_order_lists.glsl");
    parts.version = lists_version;
  }
  parts.fragments.insert(parts.fragments.end(), {"raster_order.glsl", file});
  return parts;
}

const Program& RasterPrograms::translucent(Shading shading, FragmentOrder order, TranslucentInputs inputs) {
  std::vector<std::string> defines = shaded_defines(shading);
  const bool knows_live = gl_.software && gl_.version >= 45;  // elsewhere it was not measured to be faster
  if (knows_live) defines.emplace_back("SR_LIVE");
  std::vector<std::string> fragments{"shading.h", "raster_material.glsl", "raster_lighting.glsl", "sideray.glsl"};
  if (inputs.tint_maps) defines.insert(defines.end(), {"SR_TRANSLUCENT", "SR_TINT_MAPS"});
  if (inputs.aside) {
    defines.emplace_back("SR_ASIDE");
    fragments.emplace_back("raster_aside.glsl");
  }
  Parts parts =
      ordered(surface(shading.wind, std::move(fragments), std::move(defines)), order, "raster_translucent.frag.glsl");
  if (knows_live) parts.version = live_version;
  return get(fmt::format("translucency, textures {:#x}, lobes {}, order {}{}{}{}", shading.maps, shading.lobes,
                         static_cast<uint32_t>(order), inputs.aside ? ", aside" : "",
                         inputs.tint_maps ? ", tint maps" : "", in_wind(shading.wind)),
             parts);
}

const Program& RasterPrograms::coverage(Coverage variant) {
  Parts parts = surface(variant.wind, {}, {});
  if (variant.alpha) {
    parts.fragments.push_back("raster_material.glsl");
    parts.defines.insert(parts.defines.end(), {"SR_ALPHA", "SR_MAPS 1", "SR_LOBES 0"});
  }
  if (variant.counted != CountedFragments::all) {
    parts.fragments.push_back("sideray.glsl");
    parts.defines.insert(parts.defines.end(),
                         {"SR_LOCATED", fmt::format("SR_COUNTED {}", static_cast<int>(variant.counted))});
  }
  if (variant.rest) parts.defines.push_back("SR_REST");
  if (variant.motion) {
    parts.fragments.push_back("raster_motion.glsl");
    parts.defines.push_back("SR_MOTION");
  }
  if (variant.counted == CountedFragments::misassigned) parts.fragments.push_back("raster_check.glsl");
  parts.fragments.push_back("raster_coverage.frag.glsl");
  return get(fmt::format("coverage{}{}{}, counted {}{}", variant.alpha ? ", alpha" : "", variant.rest ? ", rest" : "",
                         variant.motion ? ", motion" : "", static_cast<int>(variant.counted), in_wind(variant.wind)),
             parts);
}

const Program& RasterPrograms::sprites(SpriteShading shading, FragmentOrder order) {
  Parts parts{{"shading.h", "sprites.h"}, {"shading.h", "sprites.h"}, {"SR_SPRITES"}};
  if (shading.lit) {
    parts.vertices.push_back("raster_lighting.glsl");
    parts.defines.insert(parts.defines.end(), {"SR_LIT", "SR_LOBES 0"});
  }
  parts.vertices.push_back("raster_sprite.vert.glsl");
  if (shading.soft) parts.defines.push_back("SR_SOFT");
  if (shading.hidden) {
    parts.defines.push_back("SR_REFRACTED");
    parts.fragments.push_back("sideray.glsl");
  }
  return get(fmt::format("sprites{}{}{}, order {}", shading.lit ? ", lit" : "", shading.soft ? ", soft" : "",
                         shading.hidden ? ", hidden" : "", static_cast<uint32_t>(order)),
             ordered(std::move(parts), order, "raster_sprite.frag.glsl"));
}

const Program& RasterPrograms::sprite_coverage() {
  return get("sprite coverage",
             {{"raster_sprite.vert.glsl"}, {"raster_coverage.frag.glsl"}, {"SR_COVERAGE", "SR_ORDER 0"}});
}

const Program& RasterPrograms::light(uint32_t lobes, const LightInputs& in) {
  Parts parts{{"raster_screen.vert.glsl"},
              {"shading.h", "raster_lighting.glsl", "raster_light.frag.glsl"},
              {fmt::format("SR_LOBES {}", lobes)}};
  if (in.masks) parts.defines.push_back("SR_MASKS");
  if (in.answers) parts.defines.push_back("SR_ANSWERS");
  if (in.tints) parts.defines.push_back("SR_TINTS");
  if (in.tint_maps) parts.defines.push_back("SR_TINT_MAPS");
  return get(fmt::format("light, lobes {}{}{}{}{}", lobes, in.masks ? ", masks" : "", in.answers ? ", answers" : "",
                         in.tints ? ", tints" : "", in.tint_maps ? ", tint maps" : ""),
             parts);
}

const Program& RasterPrograms::tint_map(Shading shading) {
  return get(fmt::format("tint map, textures {:#x}, lobes {}", shading.maps, shading.lobes),
             surface(shading.wind,
                     {"shading.h", "raster_material.glsl", "raster_lighting.glsl", "raster_tint_map.frag.glsl"},
                     shaded_defines(shading)));
}

const Program& RasterPrograms::composite() {
  return get("composite", {{"raster_screen.vert.glsl"}, {"raster_composite.frag.glsl"}, {}});
}

const Program& RasterPrograms::whole() {
  return get("whole pixels", {{"raster_screen.vert.glsl"}, {"raster_composite.frag.glsl"}, {"SR_WHOLE"}});
}

const Program& RasterPrograms::motion_of_view() {
  return get("motion of the view", {{"raster_screen.vert.glsl"}, {"raster_motion_view.frag.glsl"}, {}});
}

const Program& RasterPrograms::temporal() {
  return get("temporal anti-aliasing", {{"raster_screen.vert.glsl"}, {"raster_temporal.frag.glsl"}, {}});
}

const Program& RasterPrograms::distort(uint32_t maps, bool wind) {
  return get(fmt::format("distortion, textures {:#x}{}", maps, in_wind(wind)),
             surface(wind, {"shading.h", "raster_material.glsl", "raster_distort.frag.glsl"},
                     shaded_defines({maps, 0, wind})));
}

const Program& RasterPrograms::distort_picture() {
  return get("distorted picture", {{"raster_screen.vert.glsl"}, {"raster_distort_picture.frag.glsl"}, {}});
}

const Program& RasterPrograms::peel_start() {
  return get("start of peeling", {{"raster_screen.vert.glsl"}, {"raster_order_start.frag.glsl"}, {}});
}

const Program& RasterPrograms::resolve_lists() {
  return get(
      "fragment lists",
      {{"raster_screen.vert.glsl"}, {"raster_order_lists.glsl", "raster_order_resolve.frag.glsl"}, {}, lists_version});
}

}  // namespace sideray::gl
