// Tests shading normals that contradict the geometry: they face away from the eye, or the mirror direction enters the
// surface. Raster, layer and reference follow one rule (sr_facing, sr_lifted).
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <iostream>

#include "frame/frame.h"
#include "scenes/content/shapes.h"

namespace sideray::tests {
namespace {

// Angles between shading and geometric normal, in degrees. The view is along the geometric one: from 45 degrees on the
// mirror direction enters the surface, from 90 on the normal faces away.
constexpr std::array<double, 6> tilts{0, 40, 60, 85, 100, 130};
constexpr uint32_t columns = tilts.size(), rows = 3, cell = 16;

sideray_material_desc material(uint32_t row) {
  sideray_material_desc d = scenes::opaque_material(glm::vec3(row == 0 ? 0.9f : 0.0f), row == 0 ? 0.3f : 0.04f);
  d.alpha_mode = SIDERAY_BLEND;
  if (row == 0) d.metallic = 1;
  if (row == 2) d.specular = 0, d.clearcoat = 1, d.clearcoat_roughness = 0.2f;
  return d;
}

// A column of quads for each tilt, a row for each material: rough metal, black glass, a coat. They face +z; the
// orthographic camera looks down on each at a right angle.
scenes::Content tilted_quads() {
  scenes::ContentBuilder builder("tilted");
  for (uint32_t row = 0; row < rows; ++row) builder.material(std::to_string(row), material(row));
  for (uint32_t column = 0; column < columns; ++column) {
    const uint32_t quad =
        builder.mesh(scenes::Shape().quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}), std::to_string(column));
    for (uint32_t row = 0; row < rows; ++row)
      builder.object(std::to_string(row * columns + column), quad, row, {column, row, 0});
  }
  sideray_camera camera{};
  camera.size = sizeof(camera);
  const double at[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5 * columns, 0.5 * rows, 10};
  std::copy_n(at, 12, camera.world_from_camera);
  camera.orthographic = 1, camera.half_height = 0.5f * rows;
  camera.z_near = 1, camera.z_far = 20;
  builder.camera("front", camera);
  scenes::Content content = builder.take();
  for (uint32_t column = 0; column < columns; ++column) {
    const double angle = tilts[column] * M_PI / 180;
    std::vector<float>& normals = content.meshes[column].normals;
    for (size_t i = 0; i < normals.size(); i += 3) {
      normals[i] = static_cast<float>(std::sin(angle) * 0.6),
      normals[i + 1] = static_cast<float>(std::sin(angle) * 0.8);
      normals[i + 2] = static_cast<float>(std::cos(angle));
    }
  }
  return content;
}

using Cells = std::array<double, size_t{columns} * rows>;

// Returns the mean luminance in every quad's middle.
Cells draw(sideray_translucency mode) {
  Setup setup{.width = columns * cell, .height = rows * cell, .translucency = mode, .layers = 1};
  setup.seen_in_reflections = false;
  setup.light_samples = 64;
  // No light, but one that lights nothing: without any the scene would get the default sun.
  const Frame frame = render(tilted_quads(), setup);
  Cells cells{};
  for (uint32_t y = 0; y < frame.height; ++y)
    for (uint32_t x = 0; x < frame.width; ++x) {
      const uint32_t in_x = x % cell, in_y = y % cell;
      if (in_x < 2 || in_y < 2 || in_x >= cell - 2 || in_y >= cell - 2) continue;
      double sum = 0;
      for (const char* channel : {"R", "G", "B"})
        sum += static_cast<double>(frame.planes.at(channel)[size_t{y} * frame.width + x]) / 3;
      cells[(rows - 1 - y / cell) * columns + x / cell] += sum / ((cell - 4) * (cell - 4));
    }
  return cells;
}

void print(const char* name, const Cells& cells) {
  std::cout << "  " << name;
  for (size_t i = 0; i < cells.size(); ++i) std::cout << (i % columns == 0 ? "\n    " : " ") << cells[i];
  std::cout << "\n";
}

TEST(ParityNormal, of_raster_layer_and_reference) {
  const Cells raster = draw(SIDERAY_TRANSLUCENCY_RASTER), layers = draw(SIDERAY_TRANSLUCENCY_HYBRID),
              reference = draw(SIDERAY_TRANSLUCENCY_REFERENCE);
  print("raster", raster), print("layers", layers), print("reference", reference);
  for (size_t i = 0; i < raster.size(); ++i) {
    EXPECT_NEAR(raster[i], layers[i], 0.01 * layers[i]) << i;
    EXPECT_NEAR(layers[i], reference[i], 0.1 * reference[i]) << i;
  }
}

}  // namespace
}  // namespace sideray::tests
