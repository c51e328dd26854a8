// Tests matchers over stacks of parallel walls of glass. The renderer's own check counts errors, by rays that find
// every surface.
#include <fmt/format.h>
#include <sideray/diagnostics.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

struct Matcher {
  const char* variant;
  sideray_match match;
  float threshold;
  bool is_default;
};
constexpr std::array<Matcher, 4> matchers{
    {{"--diagnose match=id", SIDERAY_MATCH_ID, 0.001f, true},
     {"--diagnose match=nearest", SIDERAY_MATCH_NEAREST, 0.001f, false},
     {"--diagnose match=distance,match-threshold=0.001", SIDERAY_MATCH_DISTANCE, 0.001f, false},
     {"--diagnose match=distance,match-threshold=0.01", SIDERAY_MATCH_DISTANCE, 0.01f, false}}};

struct Walls {
  double gap;        // between neighbours, world units
  double angle_deg;  // between the line of sight and the normal in the middle of the picture
  double distance;   // to the first wall, in the middle of the picture
  double near;       // near plane, world units
};

// Returns a rigid placement to which no axis is parallel.
glm::dmat4 world_from_stage(double unit) {
  glm::dmat4 m = glm::translate(glm::dmat4(1.0), unit * glm::dvec3(3.1, -1.7, 2.3));
  m = glm::rotate(m, 0.7, glm::normalize(glm::dvec3(0.3, 1.0, -0.2)));
  return glm::rotate(m, -0.4, glm::normalize(glm::dvec3(1.0, 0.1, 0.5)));
}

// Places the walls at the angle between line of sight and normal: across the view at 0, like floors near 90 degrees.
std::vector<Pane> panes_of(const Walls& walls) {
  constexpr int count = 4;
  const double angle = glm::radians(walls.angle_deg), reach = std::min(0.95 / std::max(std::sin(angle), 0.1), 2.0);
  const glm::dvec3 up(0, std::sin(angle), std::cos(angle)), into(0, std::cos(angle), -std::sin(angle));
  const glm::dvec3 across = 2.0 * walls.distance * glm::dvec3(1, 0, 0), along = reach * walls.distance * into;
  std::vector<Pane> panes;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 middle = glm::dvec3(0, 0, -walls.distance) - i * walls.gap * up;
    panes.push_back(
        {{{middle - across - along, middle + across - along, middle + across + along, middle - across + along}},
         world_from_stage(walls.distance)});
  }
  return panes;
}

// Marks pixels in which two pictures of the same surfaces differ: there a fragment took another surface's colour.
FailureMap differences(const StressStage& stage, const Picture& a, const Picture& b) {
  constexpr float visible = 0.02f;
  FailureMap map = map_of(stage);
  const Planes of_a(a), of_b(b);
  for (const char* channel : {"R", "G", "B"}) {
    const float *x = of_a.floats(channel), *y = of_b.floats(channel);
    for (size_t i = 0; i < of_a.pixels(); ++i)
      if (std::abs(x[i] - y[i]) > visible) map.wrong[i] = 1;
  }
  return map;
}

double share(uint64_t part, uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(whole, 1));
}

void add_rows(StressStage& stage, const char* name, const Json& parameters, const Walls& walls,
              std::vector<StressRow>& rows) {
  const Scene scene = scene_of_panes(panes_of(walls));
  const sideray_camera camera = camera_at(world_from_stage(walls.distance), 45.0, walls.near);
  const RenderOptions raster = picture_options(stage, SIDERAY_SHADOWS_OFF, SIDERAY_TRANSLUCENCY_RASTER);
  const Picture right = stage.renderer.render(scene, camera, raster).value();
  RenderOptions options = picture_options(stage);
  options.translucency->layers = 3;
  options.translucency->check = 1;
  options.picture.repeats = 1;
  for (const Matcher& matcher : matchers) {
    options.translucency->match = matcher.match;
    options.translucency->match_threshold = matcher.threshold;
    const Picture picture = stage.renderer.render(scene, camera, options).value();
    const sideray_render_stats stats = picture.stats();
    StressRow row;
    row.name = name, row.variant = matcher.variant, row.is_default = matcher.is_default;
    row.parameters = parameters;
    row.measure = "fragments with another surface's layer, share";
    row.value = share(stats.layers_misassigned, stats.layers_matched);
    row.map = differences(stage, picture, right);
    rows.push_back(row);
    row.measure = "layers that no fragment took, share";
    row.value = 1.0 - share(std::min(stats.layers_matched, stats.layers_found), stats.layers_found);
    row.bound = 0.001;
    row.map = {};
    rows.push_back(row);
  }
}

}  // namespace

std::vector<StressRow> match_gap_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double gap : swept(stage, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1}, {1e-5, 1e-3, 0.1}))
    add_rows(stage, "match-gap", {{"relative_gap", gap}, {"angle_deg", 45.0}}, {gap, 45.0, 1.0, 0.01}, rows);
  return rows;
}

std::vector<StressRow> match_distance_case(StressStage& stage) {
  constexpr double gap = 0.006;
  std::vector<StressRow> rows;
  for (const double distance : swept(stage, {0.01, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5}, {0.01, 10.0, 1e5}))
    add_rows(stage, "match-distance", {{"distance", distance}, {"gap", gap}, {"angle_deg", 30.0}},
             {gap, 30.0, distance, 0.01 * distance}, rows);
  return rows;
}

std::vector<StressRow> match_incidence_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double angle : swept(stage, {0, 30, 60, 75, 80, 85, 88, 89, 89.5, 89.9}, {0, 60, 89}))
    add_rows(stage, "match-incidence", {{"angle_deg", angle}, {"relative_gap", 1e-3}}, {1e-3, angle, 1.0, 0.01}, rows);
  return rows;
}

std::vector<StressRow> match_near_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double near : swept(stage, {1e-3, 1e-2, 0.1, 1.0}, {1e-3, 1.0}))
    add_rows(stage, "match-near", {{"near", near}, {"distance", 5.0}, {"gap", 0.02}, {"angle_deg", 30.0}},
             {0.02, 30.0, 5.0, near}, rows);
  return rows;
}

}  // namespace sideray::lab
