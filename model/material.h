// Derives values of a material, for rasterizer, tracer, plan and hosts. Any thread may call it.
#pragma once

#include <sideray/renderer.h>

#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::model {

// Returns a white, rough, opaque material of ior 1.5 without textures: sideray_material_init.
sideray_material_desc default_material();

// Throws Failure (INVALID_ARGUMENT) that names the field. The scene checks whether its textures exist.
void check_material(const sideray_material_desc& desc);

// Do the same for values of the fixed function: colours, and exponents of highlights and spots.
void check_fixed_color(const float (&color)[3], const char* what);
void check_fixed_exponent(float exponent, const char* what);
void check_fixed_material(const sideray_fixed_material& material);
// Returns the default for a material without one: lit by its base colour, plus its emissive colour.
sideray_fixed_material fixed_material_of(const sideray_material_desc& desc);
// Sets how the fixed function treats the material's alpha, and removes textures that it does not read.
void apply_fixed_material(const sideray_fixed_material& fixed, Material& material);

// Returns whether surfaces are drawn as translucent ones: BLEND, or transmission above 0.
bool is_translucent(const sideray_material_desc& desc);
// Returns whether the surfaces of an instance tint the light that passes them: coloured shadows. Unlit surfaces emit,
// additive ones take nothing away, sprites cast no shadows, and wind moves surfaces after shadows are cached.
bool tints_light(const Material& material, const Instance& instance);
// Returns whether surfaces enclose a medium if their mesh is closed.
bool has_volume(const sideray_material_desc& desc);

// Returns whether a surface bends light from the air, or blurs what is seen through it.
bool bends_light(const sideray_material_desc& desc);

// Returns the lowest alpha of base colour times texture; null = no texture.
float lowest_alpha(const sideray_material_desc& desc, const Texture* base_color);
// Surfaces that blend discard alphas below this.
inline constexpr float least_blended_alpha = 1.0f / 255.0f;

// Makes the material of a snapshot, with the same texture slots. Missing textures are null.
Material make_material(const sideray_material_desc& desc, const Texture* base_color, const Texture* metallic_roughness);

// Returns by how much the index of red light is below `ior`, and that of blue light above: 20 / dispersion is the Abbe
// number (KHR_materials_dispersion).
float index_spread(const sideray_material_desc& desc);

// Returns the absorption by Beer and Lambert: white light becomes attenuation_color after attenuation_distance. A
// channel of 0 counts as a millionth.
glm::vec3 absorption(const sideray_material_desc& desc);

// Opaque surfaces up to this roughness reflect by rays; from two thirds of it on the prefiltered environment gradually
// replaces them.
inline constexpr float most_mirrored_roughness = 0.5f;
// Returns whether shadow rays of its opaque surfaces take the inexact test. `wind` is as in Instance.
// SIDERAY_TARGET_MODEL finds foliage by how leaves are modelled: cut out of cards that are seen from both sides.
bool takes_inexact(const Material& material, uint32_t wind, sideray_inexact_target target);

}  // namespace sideray::model
