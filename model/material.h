// Derives values from a material, in one place for rasterizer, tracer, plan and hosts. Any thread may call it.
#pragma once

#include <sideray/renderer.h>

#include <glm/glm.hpp>

#include "model/snapshot.h"

namespace sideray::model {

// Returns a white, rough, opaque material of ior 1.5 without textures: sideray_material_init.
sideray_material_desc default_material();

// Throws Failure (INVALID_ARGUMENT) that names the field. Whether its textures exist is checked by the scene.
void check_material(const sideray_material_desc& desc);

// The same of the fixed function's numbers: colours, and exponents of highlights and spots.
void check_fixed_color(const float (&color)[3], const char* what);
void check_fixed_exponent(float exponent, const char* what);
void check_fixed_material(const sideray_fixed_material& material);
// Returns what is read of a material that was never given any: its base colour is lit, and its emissive colour added.
sideray_fixed_material fixed_material_of(const sideray_material_desc& desc);
// Sets what the fixed function makes of the material's alpha, and takes away textures that it does not read.
void apply_fixed_material(const sideray_fixed_material& fixed, Material& material);

// Returns whether its surfaces are drawn as translucent ones: BLEND, or transmission above 0.
bool is_translucent(const sideray_material_desc& desc);
// Returns whether the surfaces of an instance take from light that goes through them to what is behind: the shadow of glass.
// What is unlit glows, additive surfaces take nothing, sprites throw no shadows, and wind moves surfaces after shadows are
// kept.
bool tints_light(const Material& material, const Instance& instance);
// Returns whether its surfaces enclose a medium where their mesh is closed.
bool has_volume(const sideray_material_desc& desc);

// Returns whether a surface of the material bends light that comes from the air, or blurs what is seen through it.
bool bends_light(const sideray_material_desc& desc);

// Returns the least alpha that base colour and texture give; null = it has no texture.
float lowest_alpha(const sideray_material_desc& desc, const Texture* base_color);
// Alphas below this are discarded where surfaces blend.
inline constexpr float least_blended_alpha = 1.0f / 255.0f;

// Makes the material that a snapshot holds, with the same texture slots. Textures that are not there are null.
Material make_material(const sideray_material_desc& desc, const Texture* base_color, const Texture* metallic_roughness);

// Returns by how much the index of red light is below `ior` and that of blue light above: 20 / dispersion is the Abbe
// number (KHR_materials_dispersion).
float index_spread(const sideray_material_desc& desc);

// Returns the absorption by Beer and Lambert: white light keeps attenuation_color after attenuation_distance. A channel
// that lets nothing through is taken as one that lets a millionth through.
glm::vec3 absorption(const sideray_material_desc& desc);

// Opaque surfaces up to this roughness mirror what rays hit; from two thirds of it on the prefiltered environment takes
// over.
inline constexpr float most_mirrored_roughness = 0.5f;
// Returns whether the shadow rays of its opaque surfaces take the inexact test. `wind` is as in Instance. Leaves are
// modelled as two-sided foliage: cut out of cards that are seen from both sides.
bool takes_inexact(const Material& material, uint32_t wind, sideray_inexact_target target);

}  // namespace sideray::model
