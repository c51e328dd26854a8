// Tests moving glass whose layers are one frame late. Lookups are those of shaders/host/sideray.glsl, in double.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

constexpr double half_width = 0.7, half_height = 0.4, depth = 2.0, fov_deg = 45.0;
constexpr uint32_t pane_id = 1;

enum class Lookup { own_pixel, own_pixel_distance, previous_position };
struct Variant {
  const char* name;
  Lookup lookup;
  bool is_default;
};
constexpr std::array<Variant, 3> variants{
    {{"sideray_translucent", Lookup::own_pixel, false},
     {"sideray_translucent, --diagnose match=distance,match-threshold=0.01", Lookup::own_pixel_distance, false},
     {"sideray_translucent_moving", Lookup::previous_position, true}}};

// Holds the transforms of one picture of the pane, which is the rectangle |x| <= half_width, |y| <= half_height, z = 0
// in its own space.
struct Moment {
  glm::dmat4 world_from_pane = glm::dmat4(1.0), world_from_camera = glm::dmat4(1.0);
};

struct Pixel {
  int x, y;  // from the top left
};

class PixelGrid {
 public:
  PixelGrid(const StressStage& stage, const glm::dmat4& world_from_camera)
      : width_(static_cast<int>(stage.width)), height_(static_cast<int>(stage.height)), camera_(world_from_camera) {}

  glm::dvec3 eye() const { return glm::dvec3(camera_[3]); }
  glm::dvec3 direction(Pixel p) const {
    const glm::dvec3 in_camera((2.0 * (p.x + 0.5) / width_ - 1.0) * tangent() * aspect(),
                               (1.0 - 2.0 * (p.y + 0.5) / height_) * tangent(), -1.0);
    return glm::normalize(glm::dmat3(camera_) * in_camera);
  }
  // Returns the pixel that shows the point, nothing outside the picture.
  std::optional<size_t> pixel_of(glm::dvec3 world) const {
    const glm::dvec4 p = glm::inverse(camera_) * glm::dvec4(world, 1.0);
    if (p.z >= 0.0) return {};
    const double u = p.x / (-p.z * tangent() * aspect()), v = p.y / (-p.z * tangent());
    const double column = std::floor((0.5 + 0.5 * u) * width_),
                 row = height_ - 1 - std::floor((0.5 + 0.5 * v) * height_);
    if (column < 0 || column >= width_ || row < 0 || row >= height_) return {};
    return static_cast<size_t>(row) * static_cast<size_t>(width_) + static_cast<size_t>(column);
  }
  Pixel at(size_t i) const { return {static_cast<int>(i) % width_, static_cast<int>(i) / width_}; }
  double pixel_width(double at_depth) const { return 2.0 * at_depth * tangent() / height_; }

 private:
  static double tangent() { return std::tan(0.5 * glm::radians(fov_deg)); }
  double aspect() const { return static_cast<double>(width_) / height_; }

  int width_, height_;
  glm::dmat4 camera_;
};

// Returns where the ray of a pixel hits the pane, in the pane's space.
std::optional<glm::dvec3> met(const PixelGrid& grid, Pixel pixel, const glm::dmat4& world_from_pane) {
  const glm::dmat4 pane_from_world = glm::inverse(world_from_pane);
  const glm::dvec3 origin(pane_from_world * glm::dvec4(grid.eye(), 1.0));
  const glm::dvec3 along = glm::dmat3(pane_from_world) * grid.direction(pixel);
  const glm::dvec3 point = origin - origin.z / along.z * along;
  if (std::abs(point.x) > half_width || std::abs(point.y) > half_height) return {};
  return point;
}

// Returns the pane's colour: one component rises from left to right, the other from bottom to top.
glm::dvec2 colour_at(glm::dvec3 in_pane) {
  return glm::dvec2(0.5) + 0.4 * glm::dvec2(in_pane.x / half_width, in_pane.y / half_height);
}

Scene scene_at(const Moment& moment) {
  Scene scene = Scene::create().value();
  const std::array<glm::vec2, 4> signs{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  std::array<glm::vec3, 4> positions;
  std::array<glm::vec4, 4> colours;
  for (size_t i = 0; i < 4; ++i) {
    positions[i] = glm::vec3(signs[i] * glm::vec2(half_width, half_height), 0.0f);
    colours[i] = glm::vec4(colour_at(positions[i]), 0.0, 1.0);
  }
  const std::array<uint32_t, 6> indices{0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = &positions[0].x;
  mesh.colors.data = &colours[0].x;
  mesh.index_count = 6;
  mesh.indices = indices.data();
  sideray_material_desc glass = sideray_material_defaults();
  glass.alpha_mode = SIDERAY_BLEND;
  glass.unlit = glass.double_sided = 1;
  glass.base_color[3] = 0.4f;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(glass);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      instance.world_from_object[3 * column + row] = moment.world_from_pane[column][row];
  instance.surface_id = pane_id;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
  scene.commit();
  return scene;
}

// Holds the layers of the previous frame, in which fragments of this frame look themselves up.
class LateLayers {
 public:
  LateLayers(StressStage& stage, const Moment& before)
      : before_(before), grid_(stage, before.world_from_camera), picture_(draw(stage, before)), planes_(picture_) {}

  // Looks up a point of the pane that pixel `pixel` of the picture `now` shows. Returns nothing without an answer.
  std::optional<glm::dvec2> find(Lookup lookup, const Moment& now, size_t pixel, glm::dvec3 in_pane) const {
    const glm::dvec3 world(now.world_from_pane * glm::dvec4(in_pane, 1.0)), was = previous(in_pane);
    const double away = glm::distance(world, grid_.eye());
    switch (lookup) {
      case Lookup::own_pixel:
        return answer(pixel, away, slope(now, world) / 256 + rounding(world, away));
      case Lookup::own_pixel_distance:
        return answer(pixel, away, 0.01 * away);
      case Lookup::previous_position:
        break;
    }
    const std::optional<size_t> there = grid_.pixel_of(was);
    return there ? in_plane(*there, was) : std::nullopt;
  }
  // Returns whether the previous frame's ray hit the pane in the pixel that showed the point then.
  bool traced(glm::dvec3 in_pane) const {
    const std::optional<size_t> there = grid_.pixel_of(previous(in_pane));
    return there && met(grid_, grid_.at(*there), before_.world_from_pane);
  }

 private:
  static Picture draw(StressStage& stage, const Moment& moment) {
    RenderOptions options = picture_options(stage);
    options.translucency->layers = 1;
    options.picture.aovs = SIDERAY_AOV_LAYERS;
    return stage.renderer.render(scene_at(moment), camera_at(moment.world_from_camera, fov_deg, 0.1), options).value();
  }
  glm::dvec3 previous(glm::dvec3 in_pane) const {
    return glm::dvec3(before_.world_from_pane * glm::dvec4(in_pane, 1.0));
  }
  // Does what sideray_rounding() does.
  double rounding(glm::dvec3 world, double away) const {
    const glm::dvec3 most = glm::max(glm::abs(world), glm::abs(grid_.eye()));
    return std::max(away, 0.25 * std::max({most.x, most.y, most.z})) * 0x1p-22;
  }
  // Returns the change of distance that rasterization may cause, which moves vertices by up to a 256th of a pixel.
  double slope(const Moment& now, glm::dvec3 world) const {
    const glm::dvec3 from_eye = world - grid_.eye(), normal(now.world_from_pane[2]);
    const double across = glm::length(from_eye - glm::dot(from_eye, normal) * normal);
    return grid_.pixel_width(std::abs(glm::dot(from_eye, normal))) * across / glm::length(from_eye);
  }
  // Does what sideray_donor() does.
  std::optional<glm::dvec2> in_plane(size_t pixel, glm::dvec3 was) const {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(before_.world_from_pane[2]));
    const glm::dvec3 along = grid_.direction(grid_.at(pixel));
    const double toward = glm::dot(normal, along), away = glm::distance(was, grid_.eye());
    const double apart = glm::distance(grid_.eye() + along * away, was);
    const double off_plane = 0.125 * apart + rounding(was, away);
    return answer(pixel, glm::dot(normal, was - grid_.eye()) / toward, off_plane / std::abs(toward));
  }
  std::optional<glm::dvec2> answer(size_t pixel, double away, double tolerance) const {
    if (planes_.whole("layer0.surface")[pixel] != pane_id) return {};
    if (std::abs(static_cast<double>(planes_.floats("layer0.distance")[pixel]) - away) > tolerance) return {};
    return glm::dvec2(planes_.floats("layer0.R")[pixel], planes_.floats("layer0.G")[pixel]);
  }

  Moment before_;
  PixelGrid grid_;
  Picture picture_;
  Planes planes_;
};

struct Motion {
  const char* name;
  bool of_the_eye;
  glm::dvec3 direction;
};
const std::array<Motion, 3> motions{
    {{"pane across", false, {1, 0, 0}}, {"pane toward the eye", false, {0, 0, 1}}, {"eye across", true, {-1, 0, 0}}}};

void add_rows(StressStage& stage, const Motion& motion, double speed, std::vector<StressRow>& rows) {
  Moment before;
  before.world_from_pane = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -depth));
  const double pixel = PixelGrid(stage, before.world_from_camera).pixel_width(depth);
  Moment now = before;
  glm::dmat4& moved = motion.of_the_eye ? now.world_from_camera : now.world_from_pane;
  moved = glm::translate(moved, speed * pixel * motion.direction);
  const LateLayers layers(stage, before);
  const PixelGrid grid(stage, now.world_from_camera);
  // The largest change of the colour over a pixel of the previous frame, plus the rounding of half floats.
  const glm::dvec2 visible = 0.4 * pixel / glm::dvec2(half_width, half_height) + 0x1p-10;
  for (const Variant& variant : variants) {
    FailureMap map = map_of(stage);
    size_t fragments = 0, off = 0, unanswered = 0;
    for (size_t i = 0; i < map.wrong.size(); ++i) {
      const std::optional<glm::dvec3> point = met(grid, grid.at(i), now.world_from_pane);
      if (!point) continue;
      ++fragments;
      const std::optional<glm::dvec2> answer = layers.find(variant.lookup, now, i, *point);
      const bool lacks = !answer && layers.traced(*point);
      const bool differs = answer && glm::any(glm::greaterThan(glm::abs(*answer - colour_at(*point)), visible));
      unanswered += lacks, off += differs;
      map.wrong[i] = lacks || differs;
    }
    StressRow row;
    row.name = "late-glass", row.variant = variant.name, row.is_default = variant.is_default;
    row.parameters = {{"moves", motion.name}, {"pixels_a_frame", speed}};
    const auto add = [&](const char* measure, size_t count, FailureMap of_row) {
      row.measure = measure, row.map = std::move(of_row);
      row.value = static_cast<double>(count) / static_cast<double>(std::max<size_t>(fragments, 1));
      rows.push_back(row);
    };
    add("fragments whose answer is of a place more than a pixel off, share", off, std::move(map));
    add("fragments without the answer that there is, share", unanswered, {});
  }
}

}  // namespace

std::vector<StressRow> late_glass_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const Motion& motion : motions)
    for (const double speed : swept(stage, {0.0, 0.3, 1.0, 3.0, 10.0, 30.0}, {0.0, 3.0}))
      add_rows(stage, motion, speed, rows);
  return rows;
}

}  // namespace sideray::lab
