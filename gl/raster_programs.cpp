#include "gl/raster_programs.h"

#include <fmt/format.h>

#include <iterator>

namespace sideray::gl {
namespace {

struct SamplerUnit {
  const char* name;
  uint32_t unit;
};

constexpr SamplerUnit sampler_units[] = {
    {"base_color_map", 0},
    {"metallic_roughness_map", 1},
    {"normal_map", 2},
    {"occlusion_map", 3},
    {"emissive_map", 4},
    {"transmission_map", 5},
    {"thickness_map", 6},
    {"gbuffer_albedo_metallic", 0},
    {"gbuffer_normal_roughness", 1},
    {"gbuffer_emissive_occlusion", 2},
    {"gbuffer_specular", 3},
    {"gbuffer_depth", 4},
    {"traced_radiance", 0},
    {"traced_transmittance", 1},
    {"environment_specular", unit::environment_specular},
    {"environment_irradiance", unit::environment_irradiance},
    {"albedo_terms", unit::albedo_terms},
    {"directional_shadows", unit::directional_shadows},
    {"local_shadows", unit::local_shadows},
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

std::string maps_define(uint32_t map_set) {
  return fmt::format("SR_MAPS {}", map_sets[map_set]);
}

}  // namespace

uint32_t map_set_for(uint32_t maps) {
  uint32_t set = 0;
  while (set + 1 < std::size(map_sets) && (maps & ~map_sets[set]) != 0) ++set;
  return set;
}

const Program& RasterPrograms::get(const std::string& name, const Parts& parts) {
  const auto found = programs_.find(name);
  if (found != programs_.end()) return found->second;
  ShaderSpec vertex, fragment;
  vertex.files = {parts.vertex};
  vertex.defines = fragment.defines = parts.defines;
  fragment.files = parts.fragments;
  Program program(gl_, name, vertex, fragment);
  bind_interface(program);
  return programs_.emplace(name, std::move(program)).first->second;
}

const Program& RasterPrograms::gbuffer(uint32_t map_set) {
  return get(fmt::format("G-buffer, textures {}", map_set),
             {"raster_surface.vert.glsl",
              {"shading.h", "raster_material.glsl", "raster_gbuffer.frag.glsl"},
              {"SR_SHADED", maps_define(map_set)}});
}

const Program& RasterPrograms::translucent(uint32_t map_set) {
  return get(
      fmt::format("translucency, textures {}", map_set),
      {"raster_surface.vert.glsl",
       {"shading.h", "raster_material.glsl", "raster_lighting.glsl", "sideray.glsl", "raster_translucent.frag.glsl"},
       {"SR_SHADED", maps_define(map_set)}});
}

const Program& RasterPrograms::coverage(Coverage variant) {
  Parts parts{"raster_surface.vert.glsl", {}, {}};
  if (variant.alpha) {
    parts.fragments.push_back("raster_material.glsl");
    parts.defines.insert(parts.defines.end(), {"SR_ALPHA", "SR_MAPS 1"});
  }
  if (variant.count_matches) {
    parts.fragments.push_back("sideray.glsl");
    parts.defines.push_back("SR_LOCATED");
  }
  parts.fragments.push_back("raster_coverage.frag.glsl");
  return get(fmt::format("coverage{}{}", variant.alpha ? ", alpha" : "", variant.count_matches ? ", matches" : ""),
             parts);
}

const Program& RasterPrograms::light() {
  return get("light", {"raster_screen.vert.glsl", {"shading.h", "raster_lighting.glsl", "raster_light.frag.glsl"}, {}});
}

const Program& RasterPrograms::composite() {
  return get("composite", {"raster_screen.vert.glsl", {"raster_composite.frag.glsl"}, {}});
}

}  // namespace sideray::gl
