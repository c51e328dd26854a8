// Tests steppers over parallel panes: every pixel sees every pane, so that the layers are known in closed form.
#include <fmt/format.h>
#include <sideray/diagnostics.h>
#include <nlohmann/json.hpp>

#include <glm/gtc/matrix_transform.hpp>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

struct Stepper {
  const char* variant;
  sideray_step step;
  bool is_default;
};
constexpr std::array<Stepper, 3> steppers{{{"--diagnose step=multihit", SIDERAY_STEP_MULTIHIT, true},
                                           {"--diagnose step=retrace", SIDERAY_STEP_RETRACE, false},
                                           {"--diagnose step=listing", SIDERAY_STEP_LISTING, false}}};

struct PaneView {
  std::vector<Pane> panes;  // by their ids, the nearest first
  sideray_camera camera;
};

// Measures the share of layers that hold a wrong surface.
StressRow count_layers(StressStage& stage, const Scene& scene, const PaneView& view, const Stepper& stepper) {
  const auto layers = static_cast<uint32_t>(view.panes.size());
  RenderOptions options = picture_options(stage);
  options.translucency->layers = layers;
  options.translucency->step = stepper.step;
  options.picture.aovs = SIDERAY_AOV_LAYERS;
  const Picture picture = stage.renderer.render(scene, view.camera, options).value();
  const Planes planes(picture);
  StressRow row;
  row.variant = stepper.variant, row.is_default = stepper.is_default;
  row.measure = "layers lost or out of order, share";
  row.map = map_of(stage);
  uint64_t wrong = 0;
  for (uint32_t k = 0; k < layers; ++k) {
    const uint32_t* surface = planes.whole(fmt::format("layer{}.surface", k));
    for (size_t i = 0; i < planes.pixels(); ++i)
      if (surface[i] != k + 1) row.map.wrong[i] = 1, ++wrong;
  }
  row.value = static_cast<double>(wrong) / static_cast<double>(planes.pixels() * layers);
  return row;
}

void add_rows(StressStage& stage, const char* name, const Json& parameters, const PaneView& view,
              std::vector<StressRow>& rows) {
  const Scene scene = scene_of_panes(view.panes);
  for (const Stepper& stepper : steppers) {
    rows.push_back(count_layers(stage, scene, view, stepper));
    rows.back().name = name;
    rows.back().parameters = parameters;
  }
}

std::vector<Pane> stack(double first, double gap, size_t count) {
  std::vector<Pane> panes;
  for (size_t i = 0; i < count; ++i) panes.push_back(pane_across(first + gap * static_cast<double>(i)));
  return panes;
}

sideray_camera camera_in(const glm::dmat4& world_from_camera, double unit = 1.0) {
  return camera_at(world_from_camera, 45.0, 0.1 * unit);
}

}  // namespace

std::vector<StressRow> layer_gap_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double gap : swept(stage, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0}, {1e-6, 1e-3, 1.0}))
    add_rows(stage, "layer-gap", {{"relative_gap", gap}, {"panes", 4}},
             {stack(1.0, gap, 4), camera_in(glm::dmat4(1.0))}, rows);
  return rows;
}

std::vector<StressRow> coplanar_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double panes : swept(stage, {2, 3, 4, 6, 8}, {2, 4}))
    add_rows(stage, "coplanar", {{"panes", static_cast<int>(panes)}},
             {stack(3.0, 0.0, static_cast<size_t>(panes)), camera_in(glm::dmat4(1.0))}, rows);
  return rows;
}

std::vector<StressRow> layer_count_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double panes : swept(stage, {1, 2, 3, 4, 5, 6, 7, 8}, {1, 2, 4, 8}))
    add_rows(stage, "layer-count", {{"panes", static_cast<int>(panes)}},
             {stack(2.0, 0.7, static_cast<size_t>(panes)), camera_in(glm::dmat4(1.0))}, rows);
  return rows;
}

std::vector<StressRow> instance_scale_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double scale : swept(stage, {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3}, {1e-3, 1.0, 1e3}))
    for (const bool mirrored : {false, true}) {
      PaneView view{stack(1.0, 0.01, 3), camera_in(glm::dmat4(1.0), scale)};
      for (Pane& pane : view.panes)
        pane.world_from_pane = glm::scale(glm::dmat4(1.0), glm::dvec3(mirrored ? -scale : scale, scale, scale));
      add_rows(stage, "instance-scale", {{"scale", scale}, {"mirrored", mirrored}}, view, rows);
    }
  return rows;
}

std::vector<StressRow> world_offset_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double offset : swept(stage, {0.0, 1.0, 1e2, 1e4, 1e5, 1e6}, {0.0, 1e6})) {
    const glm::dmat4 place = glm::translate(glm::dmat4(1.0), offset * glm::dvec3(1.0, -0.7, 0.3));
    PaneView view{stack(1.0, 0.01, 3), camera_in(place)};
    for (Pane& pane : view.panes) pane.world_from_pane = place;
    add_rows(stage, "world-offset", {{"offset", offset}}, view, rows);
  }
  return rows;
}

}  // namespace sideray::lab
