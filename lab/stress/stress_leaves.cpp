// Tests leaf cards from several pixels wide to far below one pixel, against their known positions: a grid of squares,
// each a quarter of its cell, so that every point's shadow and the shaded share are known.
#include <algorithm>
#include <cmath>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

constexpr double eye_height = 5.0, leaf_height = 10.0, fov_deg = 45.0;
constexpr double turn = 0.37;  // radians of the grid about the line of sight, so that rows of pixels and leaves do not
                               // cause moire
constexpr double across_x = 0.3137, across_z = 0.7211;  // of a cell, so that no edge lies on a pixel's centre

enum class Leaf { triangles, nearest, trilinear };
struct Method {
  const char* variant;
  sideray_shadows shadows;
  Leaf leaf;
  bool is_default;
};
constexpr std::array<Method, 5> methods{
    {{"--shadows map, cards of two triangles", SIDERAY_SHADOWS_MAP, Leaf::triangles, false},
     {"--shadows exact, cards of two triangles", SIDERAY_SHADOWS_EXACT, Leaf::triangles, false},
     {"--shadows inexact, cards of two triangles", SIDERAY_SHADOWS_INEXACT, Leaf::triangles, true},
     {"--shadows inexact, cut out of a nearest texture", SIDERAY_SHADOWS_INEXACT, Leaf::nearest, true},
     {"--shadows inexact, cut out of a trilinear texture", SIDERAY_SHADOWS_INEXACT, Leaf::trilinear, true}}};

struct Grid {
  double width;        // width of a card, world units; cells are twice as wide
  double half_extent;  // of the whole grid
};

// Returns the distance from the nearest edge, in widths of a leaf: above 0 inside it.
double depth_in_card(double u, double v) {
  const auto inside = [](double part) {
    return part < 0.5 ? 2.0 * std::min(part, 0.5 - part) : -2.0 * std::min(part - 0.5, 1.0 - part);
  };
  return std::min(inside(u), inside(v));
}

// Does the same for the cut-out of one opaque texel among four, interpolated, which is smaller than the texel.
double depth_in_texel(double u, double v) {
  const auto tent = [](double part) {
    const double texels = 2.0 * std::abs(part - 0.25);
    return std::max(1.0 - std::min(texels, 2.0 - texels), 0.0);
  };
  return tent(u) * tent(v) - 0.5;
}

double depth_in_leaf(const Grid& grid, Leaf leaf, double x, double z) {
  const double c = std::cos(turn), s = std::sin(turn), cell = 2.0 * grid.width;
  const double u = (c * x + s * z) / cell - across_x, v = (c * z - s * x) / cell - across_z;
  const double in_u = u - std::floor(u), in_v = v - std::floor(v);
  return leaf == Leaf::trilinear ? depth_in_texel(in_u, in_v) : depth_in_card(in_u, in_v);
}

// Returns the share of the area that leaves cover.
double coverage_of(Leaf leaf) {
  return leaf == Leaf::trilinear ? 0.5 - 0.5 * std::log(2.0) : 0.25;
}

void set_turned(sideray_instance_desc& instance) {
  const double c = std::cos(turn), s = std::sin(turn);
  const double columns[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
  std::copy(columns, columns + 9, instance.world_from_object);
}

void add_squares(Scene& scene, const Grid& grid) {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
  const double cell = 2.0 * grid.width;
  const int count = static_cast<int>(std::ceil(grid.half_extent / cell));
  for (int j = -count; j < count; ++j)
    for (int i = -count; i < count; ++i) {
      const double x = (i + across_x) * cell, z = (j + across_z) * cell;
      const auto first = static_cast<uint32_t>(positions.size());
      for (const auto& [u, v] : {std::pair{0, 0}, {0, 1}, {1, 1}, {1, 0}})
        positions.emplace_back(glm::dvec3(x + u * grid.width, leaf_height, z + v * grid.width));
      for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + k);
    }
  sideray_instance_desc instance{};
  instance.mesh = add_triangles(scene, positions, indices);
  sideray_material_desc leaf = sideray_material_defaults();
  leaf.double_sided = 1;
  instance.material = scene.add_material(leaf);
  set_turned(instance);
  instance.surface_id = 2;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

// Adds one card of the grid's size, cut out by a repeating texture of 2x2 texels.
void add_cut_out(Scene& scene, const Grid& grid, sideray_filter filter) {
  const double half = grid.half_extent, cell = 2.0 * grid.width;
  const std::array<glm::vec3, 4> positions{glm::vec3(-half, leaf_height, -half), glm::vec3(-half, leaf_height, half),
                                           glm::vec3(half, leaf_height, half), glm::vec3(half, leaf_height, -half)};
  std::array<glm::vec2, 4> uv;
  for (size_t k = 0; k < 4; ++k)
    uv[k] = glm::dvec2(double{positions[k].x} / cell - across_x, double{positions[k].z} / cell - across_z);
  constexpr std::array<uint32_t, 6> indices{0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6;
  mesh.positions.data = &positions[0].x, mesh.uv0.data = &uv[0].x;
  mesh.indices = indices.data();
  constexpr std::array<uint8_t, 16> texels{255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 0};
  sideray_material_desc leaf = sideray_material_defaults();
  leaf.double_sided = 1;
  leaf.alpha_mode = SIDERAY_MASK;
  leaf.alpha_cutoff = 0.5f;
  leaf.base_color_texture.texture = scene.add_texture(2, 2, SIDERAY_RGBA8, texels.data());
  leaf.base_color_texture.wrap_u = leaf.base_color_texture.wrap_v = SIDERAY_REPEAT;
  leaf.base_color_texture.filter = filter;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(leaf);
  set_turned(instance);
  instance.surface_id = 2;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

// The camera looks down on a floor from below the leaves, which it does not see; light falls straight down.
Scene scene_of(const Grid& grid, Leaf leaf) {
  Scene scene = Scene::create().value();
  set_light_from_above(scene);
  const double half = grid.half_extent;
  add_quad(scene, {{{{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}}}},
           sideray_material_defaults(), 1);
  if (leaf == Leaf::triangles)
    add_squares(scene, grid);
  else
    add_cut_out(scene, grid, leaf == Leaf::nearest ? SIDERAY_NEAREST : SIDERAY_TRILINEAR);
  scene.commit();
  return scene;
}

sideray_camera camera() {
  glm::dmat4 world_from_camera(1.0);
  world_from_camera[1] = {0, 0, -1, 0};
  world_from_camera[2] = {0, 1, 0, 0};
  world_from_camera[3] = {0, eye_height, 0, 1};
  return camera_at(world_from_camera, fov_deg, 0.1);
}

double pixel_width(const StressStage& stage) {
  return 2.0 * eye_height * std::tan(0.5 * glm::radians(fov_deg)) / stage.height;
}

std::vector<StressRow> rows_of(StressStage& stage, const Method& method, double width_px) {
  const double pixel = pixel_width(stage);
  const Grid grid{width_px * pixel, 0.6 * pixel * stage.width};
  RenderOptions options = picture_options(stage, method.shadows, SIDERAY_TRANSLUCENCY_OFF);
  const Scene scene = scene_of(grid, method.leaf);
  const Picture picture = stage.renderer.render(scene, camera(), options).value();
  const Planes planes(picture);
  const float* lit = planes.floats("R");  // the sun is the only light on the floor
  const float half_lit = 0.5f * *std::max_element(lit, lit + planes.pixels());
  StressRow row;
  row.name = "leaves", row.variant = method.variant, row.is_default = method.is_default;
  row.parameters = {{"leaf_px", width_px}};
  row.map = map_of(stage);
  double wrong = 0, judged = 0, dark = 0;
  for (uint32_t y = 0; y < stage.height; ++y)
    for (uint32_t x = 0; x < stage.width; ++x) {
      const size_t i = size_t{y} * stage.width + x;
      const double depth = depth_in_leaf(grid, method.leaf, (x + 0.5 - 0.5 * stage.width) * pixel,
                                         (y + 0.5 - 0.5 * stage.height) * pixel);
      const bool is_dark = lit[i] < half_lit;
      dark += is_dark;
      // At an edge float rounding decides, so such points are not counted.
      if (std::abs(depth) * grid.width < 1e-5 * eye_height) continue;
      judged += 1.0;
      if (is_dark == (depth > 0)) continue;
      wrong += 1.0;
      row.map.wrong[i] = 1;
    }
  std::vector<StressRow> rows;
  const double pixels = static_cast<double>(stage.width) * stage.height;
  row.measure = "pixels whose shadow is not that of what is above their centre, share";
  row.value = judged > 0 ? wrong / judged : 0.0;
  rows.push_back(row);
  row.map = {};
  row.measure = "shaded share off from the closed form";
  const double coverage = coverage_of(method.leaf);
  row.value = std::abs(dark / pixels - coverage);
  row.bound = 4.0 * std::sqrt(coverage * (1.0 - coverage) / pixels);
  rows.push_back(row);
  return rows;
}

}  // namespace

std::vector<StressRow> leaves_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double width : swept(stage, {4.31, 2.17, 1.13, 0.53, 0.27, 0.13}, {2.17, 0.27}))
    for (const Method& method : methods)
      for (StressRow& row : rows_of(stage, method, width)) rows.push_back(std::move(row));
  return rows;
}

}  // namespace sideray::lab
