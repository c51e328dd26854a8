// Makes a grid of spheres: a row for each lobe of the material, whose parameter grows to the right. For tests, and to
// look at.
#pragma once

#include <cmath>
#include <string>

#include "scenes/content/shapes.h"

namespace sideray::tests {

inline constexpr int lobe_columns = 5;
inline constexpr const char* lobe_rows[] = {
    "coat", "coat over bumps", "sheen", "diffuse transmission", "specular", "metal", "film", "brushed", "textured"};

// Returns a normal map of soft bumps.
inline scenes::Texture bumps() {
  constexpr uint32_t size = 64;
  scenes::Texture texture{"bumps", size, size, {}, false};
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const float a = 6.2831853f / 16.0f, dx = 0.6f * std::cos(a * static_cast<float>(x)),
                  dy = 0.6f * std::cos(a * static_cast<float>(y)), scale = 127.5f / std::sqrt(dx * dx + dy * dy + 1);
      for (const float n : {dx, dy, 1.0f}) texture.rgba.push_back(static_cast<uint8_t>(127.5f + n * scale));
      texture.rgba.push_back(255);
    }
  return texture;
}

struct LobeTextures {
  uint32_t chequer, coarse_chequer, bumps;
};

// `t` runs from 0 to 1 along the row.
inline sideray_material_desc lobe_material(int row, float t, const LobeTextures& textures) {
  sideray_material_desc d = scenes::opaque_material({0.5f, 0.05f, 0.05f}, 0.7f);
  switch (row) {
    case 1:
      d.normal_texture.texture = textures.bumps;
      [[fallthrough]];
    case 0:
      d.clearcoat = 1, d.clearcoat_roughness = t;
      break;
    case 2:
      d.base_color[0] = 0.05f, d.base_color[2] = 0.2f;
      d.sheen_color[0] = 1, d.sheen_color[1] = 0.8f, d.sheen_color[2] = 0.5f, d.sheen_roughness = 0.1f + 0.9f * t;
      break;
    case 3:
      d.base_color[1] = 0.4f, d.roughness = 1;
      d.diffuse_transmission = t, d.diffuse_transmission_color[0] = 0.2f, d.diffuse_transmission_color[2] = 0.3f;
      break;
    case 4:
      d.roughness = 0.2f, d.specular = t, d.specular_color[0] = 4, d.specular_color[2] = 0.5f;
      break;
    case 5:
      d.base_color[0] = 1, d.base_color[1] = 0.75f, d.base_color[2] = 0.35f, d.metallic = 1, d.roughness = t;
      break;
    case 6:
      d.roughness = 0.3f, d.metallic = t, d.iridescence = 1, d.iridescence_ior = 1.6f;
      d.iridescence_thickness_min = 100, d.iridescence_thickness_max = 250 + 500 * t;
      d.iridescence_thickness_texture.texture = textures.coarse_chequer;
      break;
    case 7:
      d.roughness = 0.3f, d.metallic = 1, d.anisotropy = t, d.anisotropy_rotation = 1;
      break;
    default:
      d.base_color[1] = 0.5f, d.clearcoat = 1, d.sheen_color[2] = 1, d.sheen_roughness = 0.4f;
      d.base_color_texture.texture = textures.chequer;
      d.normal_texture.texture = textures.bumps;
      d.normal_scale = t;
      d.clearcoat_texture.texture = textures.coarse_chequer;
      d.clearcoat_roughness = 0.8f * t, d.clearcoat_roughness_texture.texture = textures.chequer;
      d.sheen_color_texture.texture = textures.coarse_chequer;
  }
  return d;
}

// Returns the grid. `translucent` makes surfaces BLEND with alpha 1, so that they use the translucent pass and layers.
inline scenes::Content lobe_grid(bool translucent) {
  scenes::ContentBuilder builder("lobes");
  const uint32_t chequer = builder.checker("chequer", {255, 255, 255}, {90, 120, 60}, 16);
  const uint32_t coarse = builder.checker("coarse chequer", {255, 255, 255}, {30, 30, 30}, 4);
  const LobeTextures textures{chequer, coarse, coarse + 1};  // the last is appended below
  const uint32_t sphere = builder.mesh(scenes::Shape().sphere(glm::vec3(0), 0.45f, 64), "sphere");
  const int rows = static_cast<int>(std::size(lobe_rows));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < lobe_columns; ++column) {
      sideray_material_desc d =
          lobe_material(row, static_cast<float>(column) / static_cast<float>(lobe_columns - 1), textures);
      if (translucent) d.alpha_mode = SIDERAY_BLEND;
      const std::string name = std::string(lobe_rows[row]) + " " + std::to_string(column);
      builder.object(name, sphere, builder.material(name, d),
                     {column - 0.5 * (lobe_columns - 1), 0.5 * (rows - 1) - row, 0});
    }
  builder.light("sun", scenes::sun_light({-0.5f, -0.7f, -0.6f}, glm::vec3(2)));
  builder.light("behind", scenes::sun_light({0.3f, -0.2f, 1}, glm::vec3(3)));
  sideray_camera camera{};
  camera.size = sizeof(camera);
  const double at[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 10};
  std::copy_n(at, 12, camera.world_from_camera);
  camera.orthographic = 1, camera.half_height = 0.5f * static_cast<float>(rows);
  camera.z_near = 1, camera.z_far = 20;
  builder.camera("front", camera);
  scenes::Content content = builder.take();
  content.textures.push_back(bumps());
  return content;
}

}  // namespace sideray::tests
