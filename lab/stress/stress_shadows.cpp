// Tests inexact shadow tests (listing 50-3 and others) against known truth: a floor that wind has moved below its rest
// pose, which nothing shadows, and a floor under an occluder, which is dark everywhere.
#include <fmt/format.h>
#include <sideray/diagnostics.h>

#include <cmath>

#include "lab/stress/stress_scene.h"
#include "scenes/content/content.h"

namespace sideray::lab {
namespace {

struct Test {
  const char* variant;
  sideray_shadows shadows;
  sideray_inexact inexact;
  uint32_t poses;
  bool is_default = false;
  bool has_closed_form = false;
};
constexpr std::array<Test, 6> tests{
    {{"--shadows exact --poses rest", SIDERAY_SHADOWS_EXACT, SIDERAY_EXACT, SIDERAY_POSES_REST},
     {"--inexact tmin --poses rest", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_TMIN, SIDERAY_POSES_REST, false,
      true},
     {"origin moved by u B (no option) --poses rest", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_ORIGIN,
      SIDERAY_POSES_REST, false, true},
     {"--inexact bounded --poses rest", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_BOUNDED, SIDERAY_POSES_REST},
     {"--inexact restpose --poses rest", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_RESTPOSE, SIDERAY_POSES_REST},
     {"--inexact restpose --poses 16", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_RESTPOSE, 16,
      true}}};

// Without OpenGL visible surfaces are found by rays in the pose that shadow rays hit, so no test is inexact, and the
// default represents all of them.
bool is_tested(const StressStage& stage, const Test& test) {
  return !stage.by_rays || test.shadows == SIDERAY_SHADOWS_EXACT || test.is_default;
}

constexpr double occluder_height = 0.2;

// Returns a square of 100 around the y axis at height y.
Pane level(double y) {
  constexpr double half = 50.0;
  return {{{{-half, y, half}, {half, y, half}, {half, y, -half}, {-half, y, -half}}}};
}

sideray_camera looking_down_from(double height, double near) {
  glm::dmat4 world_from_camera(1.0);
  world_from_camera[1] = {0, 0, -1, 0};
  world_from_camera[2] = {0, 1, 0, 0};
  world_from_camera[3] = {0, height, 0, 1};
  return camera_at(world_from_camera, 45.0, near);
}

Scene lit_from_above() {
  Scene scene = Scene::create().value();
  set_light_from_above(scene);
  return scene;
}

sideray_material_desc floor_material() {
  sideray_material_desc material = sideray_material_defaults();
  material.double_sided = 1;
  material.inexact_shadow = 1;
  return material;
}

// Returns a floor whose drawn pose is below its rest pose at y = 0.
Scene moved_floor(double amplitude) {
  Scene scene = lit_from_above();
  sideray_wind_desc wind = sideray_wind_defaults();
  wind.direction[0] = wind.direction[2] = 0.0f;
  wind.direction[1] = -1.0f;
  wind.amplitude = static_cast<float>(amplitude);
  wind.height = 1.0f;
  wind.branch_amplitude = wind.leaf_amplitude = 0.0f;
  // The trunk sways by its amplitude at its height.
  Pane floor = level(1.0);
  floor.world_from_pane[3][1] = -1.0;
  add_quad(scene, floor, floor_material(), 1, scene.add_wind(wind));
  scene.commit();
  return scene;
}

Scene floor_below_an_occluder() {
  Scene scene = lit_from_above();
  add_quad(scene, level(0.0), floor_material(), 1);
  sideray_material_desc ceiling = sideray_material_defaults();
  ceiling.double_sided = 1;
  add_quad(scene, level(occluder_height), ceiling, 2);
  scene.commit();
  return scene;
}

struct Shadow {
  FailureMap wrong;
  double share_wrong = 0;
  double mean_z = 0;             // planar distance of the visible surface
  double mean_hit_distance = 0;  // mean over dark pixels; 0 = none is dark
};

enum class Wrong { dark, lit };

Shadow draw(StressStage& stage, const Scene& scene, const sideray_camera& camera, const Test& test, double bias,
            Wrong wrong_are) {
  RenderOptions options = picture_options(stage, test.shadows);
  options.shadows->inexact = test.inexact;
  options.shadows->inexact_bias = static_cast<float>(bias);
  options.poses->poses = test.poses;
  options.picture.aovs = SIDERAY_AOV_Z | SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE;
  const Picture picture = stage.renderer.render(scene, camera, options).value();
  const Planes planes(picture);
  const float *lit = planes.floats("shadow.0"), *z = planes.floats("Z"), *hit = planes.floats("hitdist.0");
  Shadow shadow;
  shadow.wrong = map_of(stage);
  double dark = 0, distance = 0, wrong = 0;
  for (size_t i = 0; i < planes.pixels(); ++i) {
    const bool is_dark = lit[i] < 0.5f;
    if (is_dark == (wrong_are == Wrong::dark)) shadow.wrong.wrong[i] = 1, wrong += 1.0;
    if (is_dark && std::isfinite(hit[i])) dark += 1.0, distance += double{hit[i]};
    shadow.mean_z += double{z[i]};
  }
  const auto pixels = static_cast<double>(planes.pixels());
  shadow.share_wrong = wrong / pixels;
  shadow.mean_z /= pixels;
  shadow.mean_hit_distance = dark > 0 ? distance / dark : 0.0;
  return shadow;
}

// Returns four standard errors of a share of independent pixels.
double noise_of(const StressStage& stage, double probability) {
  const double pixels = double{static_cast<double>(stage.width)} * stage.height;
  return 4.0 * std::sqrt(probability * (1.0 - probability) / pixels);
}

StressRow row_of(const char* name, const Test& test, const char* measure, double value, double bound) {
  StressRow row;
  row.name = name, row.variant = test.variant, row.is_default = test.is_default;
  row.measure = measure, row.value = value, row.bound = bound;
  return row;
}

std::vector<double> ratios(const StressStage& stage) {
  return swept(stage, {0.0625, 0.125, 0.25, 0.5, 0.75, 0.9}, {0.125, 0.5});
}

}  // namespace

std::vector<StressRow> wind_gap_case(StressStage& stage) {
  constexpr double height = 5.0;
  std::vector<StressRow> rows;
  const sideray_camera camera = looking_down_from(height, 0.1);
  for (const double amplitude : swept(stage, {0.01, 0.1, 1.0}, {0.1})) {
    const Scene scene = moved_floor(amplitude);
    const double gap = draw(stage, scene, camera, tests[0], 0.0, Wrong::dark).mean_z - height;
    for (const double ratio : ratios(stage))
      for (const Test& test : tests) {
        if (!is_tested(stage, test)) continue;
        const double bias = gap / ratio;
        const Shadow shadow = draw(stage, scene, camera, test, bias, Wrong::dark);
        std::vector<StressRow> measured{
            row_of("wind-gap", test, "lit pixels in false shadow, share", shadow.share_wrong, 0.0)};
        measured.back().map = shadow.wrong;
        if (test.has_closed_form)
          measured.push_back(row_of("wind-gap", test, "false shadow off from the closed form g / B",
                                    std::abs(shadow.share_wrong - ratio), noise_of(stage, ratio)));
        for (StressRow& row : measured) {
          row.parameters = {{"wind_amplitude", amplitude}, {"gap", gap}, {"bias", bias}, {"gap_by_bias", ratio}};
          rows.push_back(std::move(row));
        }
      }
  }
  return rows;
}

std::vector<StressRow> contact_case(StressStage& stage) {
  std::vector<StressRow> rows;
  const Scene scene = floor_below_an_occluder();
  const sideray_camera camera = looking_down_from(0.5 * occluder_height, 0.01 * occluder_height);
  for (const double ratio : ratios(stage))
    for (const Test& test : tests) {
      if (!is_tested(stage, test)) continue;
      const double bias = occluder_height / ratio;
      const Shadow shadow = draw(stage, scene, camera, test, bias, Wrong::lit);
      std::vector<StressRow> measured{
          row_of("contact", test, "occluded pixels that are lit, share", shadow.share_wrong, 0.0)};
      measured.back().map = shadow.wrong;
      if (test.has_closed_form)
        measured.push_back(row_of("contact", test, "lost occluders off from the closed form 1 - c / B",
                                  std::abs(shadow.share_wrong - (1.0 - ratio)), noise_of(stage, ratio)));
      if (shadow.mean_hit_distance > 0.0)
        measured.push_back(row_of("contact", test, "reported hit distance off, share of the true one",
                                  std::abs(shadow.mean_hit_distance / occluder_height - 1.0), 0.01));
      for (StressRow& row : measured) {
        row.parameters = {{"occluder_distance", occluder_height}, {"bias", bias}, {"distance_by_bias", ratio}};
        rows.push_back(std::move(row));
      }
    }
  return rows;
}

std::vector<StressRow> self_shadow_case(StressStage& stage) {
  std::vector<StressRow> rows;
  const Test by_default{"--shadows inexact", SIDERAY_SHADOWS_INEXACT, SIDERAY_INEXACT_RESTPOSE, 16,
                        true};
  for (const double distance : swept(stage, {0.1, 1.0, 10.0, 100.0, 1e3, 1e4}, {0.1, 1e4}))
    for (const double near : swept(stage, {1e-3, 1e-2, 0.1}, {1e-3})) {
      Scene scene = Scene::create().value();
      sideray_light sun{};
      sun.size = sizeof(sun);
      sun.type = SIDERAY_LIGHT_DIRECTIONAL;
      sun.direction[0] = 0.9f, sun.direction[1] = -0.3f, sun.direction[2] = 0.2f;
      for (float& c : sun.intensity) c = 1.0f;
      scene.set_lights({&sun, 1});
      Pane floor = level(0.0);
      floor.world_from_pane[0][0] = floor.world_from_pane[1][1] = floor.world_from_pane[2][2] = distance;
      add_quad(scene, floor, sideray_material_defaults(), 1);
      scene.commit();
      const double eye[3] = {0.1 * distance, distance, 0.3 * distance}, target[3] = {0, 0, -2.0 * distance};
      sideray_camera camera = scenes::look_at(eye, target, 45.0f);
      camera.z_near = static_cast<float>(near * distance);
      const Shadow shadow = draw(stage, scene, camera, by_default, 0.5, Wrong::dark);
      rows.push_back(row_of("self-shadow", by_default, "pixels of a plain floor in its own shadow, share",
                            shadow.share_wrong, 0.0));
      rows.back().map = shadow.wrong;
      rows.back().parameters = {{"distance", distance}, {"near_by_distance", near}};
    }
  return rows;
}

}  // namespace sideray::lab
