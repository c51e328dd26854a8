// Measures the ghost of a shadow whose caster has jumped, and the flicker of a sequence in which everything rests.
#include <cmath>

#include "lab/metrics/flicker.h"
#include "lab/metrics/temporal.h"
#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

struct Method {
  const char* variant;
  bool denoise, taa, is_default;
};
constexpr std::array<Method, 4> methods{{{"--denoise off --taa off", false, false, false},
                                         {"--denoise on --taa off", true, false, false},
                                         {"--denoise off --taa on", false, true, false},
                                         {"--denoise on --taa on", true, true, true}}};

constexpr uint32_t frames_before = 2 * SettleMeter::period;
constexpr double eye_height = 5.0;

// Holds a floor below a card that the camera does not see.
struct Stage {
  Scene scene;
  sideray_instance card;
};

Stage stage_of(double sun_deg) {
  Stage stage{Scene::create().value(), 0};
  sideray_light sun{};
  sun.size = sizeof(sun);
  sun.type = SIDERAY_LIGHT_DIRECTIONAL;
  sun.direction[1] = -1.0f;
  sun.angular_diameter_deg = static_cast<float>(sun_deg);
  for (float& c : sun.intensity) c = 2.0f;
  stage.scene.set_lights({&sun, 1});
  constexpr double half = 20.0, card = 1.0, above = 2.0 * eye_height;
  sideray_material_desc material = sideray_material_defaults();
  material.double_sided = 1;
  add_quad(stage.scene, {{{{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}}}}, material, 1);
  stage.card = add_quad(stage.scene,
                        {{{{-card, above, card}, {card, above, card}, {card, above, -card}, {-card, above, -card}}}},
                        material, 2);
  stage.scene.commit();
  return stage;
}

void move_card(Stage& stage, double x) {
  const double world_from_object[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0};
  stage.scene.move_instance(stage.card, world_from_object);
  stage.scene.commit();
}

struct InTime {
  Settling settling;
  double change = 0;  // root mean square from a frame to the next, at rest
  FailureMap ghost;   // the ghost half a period after the jump
};

FailureMap differences(const StressStage& stage, const scenes::Image& a, const scenes::Image& b) {
  constexpr float visible = 0.05f;
  FailureMap map = map_of(stage);
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < map.wrong.size(); ++i)
      map.wrong[i] |= static_cast<uint8_t>(std::abs(a.planes[c].values[i] - b.planes[c].values[i]) > visible);
  return map;
}

InTime play(StressStage& stage, const Method& method, double sun_deg) {
  constexpr double left = -1.2, right = 1.2;
  Stage shown = stage_of(sun_deg);
  glm::dmat4 world_from_camera(1.0);
  world_from_camera[1] = {0, 0, -1, 0}, world_from_camera[2] = {0, 1, 0, 0};
  world_from_camera[3] = {0, eye_height, 0, 1};
  const sideray_camera camera = camera_at(world_from_camera, 45.0, 0.1);
  RenderOptions options = picture_options(stage, SIDERAY_SHADOWS_INEXACT);
  options.picture.denoise = method.denoise;
  options.picture.taa = method.taa;
  const auto draw = [&](uint32_t frame) {
    set_frame(options, frame, frame > 0);
    return image_of(stage.renderer.render(shown.scene, camera, options).value());
  };
  move_card(shown, left);
  for (uint32_t frame = 0; frame + 1 < frames_before; ++frame) draw(frame);
  SettleMeter settle;
  settle.add(draw(frames_before - 1));
  move_card(shown, right);
  std::vector<scenes::Image> pictures;
  for (uint32_t frame = 0; frame < SettleMeter::held; ++frame) pictures.push_back(draw(frames_before + frame));
  // At rest the truth does not change: any one picture serves as the reference.
  FlickerMeter flicker;
  for (size_t i = 0; i < pictures.size(); ++i) {
    settle.add(pictures[i]);
    if (i >= pictures.size() - 2 * SettleMeter::period) flicker.add(pictures[i], pictures.back());
  }
  return {settle.result(), std::sqrt(2.0 * flicker.result().error_energy),
          differences(stage, pictures[SettleMeter::period / 2], pictures.back())};
}

// Returns, in closed form, for how many frames averages alone keep a ghost above `share_left` (docs/sequences.md):
// masks are the mean of at most 8 frames, and anti-aliasing weights each new picture by a tenth. Ghosts that rejection
// of the history recognizes end sooner.
double frames_until(const Method& method, double share_left) {
  const double of_masks = method.denoise ? 8.0 : 1.0;
  return of_masks + (method.taa ? std::log(std::min(share_left, 1.0)) / std::log(0.9) : 0.0);
}

}  // namespace

std::vector<StressRow> settling_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double sun_deg : swept(stage, {0.0, 0.53, 4.0}, {0.0, 4.0}))
    for (const Method& method : methods) {
      const InTime seen = play(stage, method, sun_deg);
      StressRow row;
      row.name = "settling", row.variant = method.variant, row.is_default = method.is_default;
      row.parameters = {{"sun_deg", sun_deg}};
      const auto add = [&](const char* measure, double value, double bound, FailureMap map) {
        row.measure = measure, row.value = value, row.bound = bound, row.map = std::move(map);
        rows.push_back(row);
      };
      // A sharp shadow has no noise that could hide its ghost.
      if (sun_deg > 0.0) {
        add("flicker at rest, root mean square of PNG values from frame to frame", seen.change, 1.0 / 255, {});
        continue;
      }
      add("frames until half of a ghost is gone", seen.settling.half_life, frames_until(method, 0.5), seen.ghost);
      add("frames until no ghost is left", seen.settling.settle_time,
          frames_until(method, SettleMeter::tolerance / seen.settling.ghost), {});
    }
  return rows;
}

}  // namespace sideray::lab
