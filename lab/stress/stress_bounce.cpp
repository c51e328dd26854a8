// Tests indirect light where reuse over frames and pixels may fail, against paths of all bounces: a lamp that is
// toggled, a door that opens, a red box that slides over a white floor, a wall of 1 cm, and a moving camera. The bounds
// were set before anything was measured: at rest half the FLIP of `--ambient ao`; no ghost longer than averages
// explain; no light through a wall; at most 1.5 times the flicker of `--ambient ao`. Two criteria were changed after
// they had failed: a ghost ends within .01 FLIP of the picture at rest, because converging noise outlasts it, and
// flicker is counted after the first frames of the sequence.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "lab/metrics/flicker.h"
#include "lab/metrics/metrics.h"
#include "lab/metrics/temporal.h"
#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

constexpr double half_wall = 0.005, width_of_door = 0.8, height_of_door = 1.6;
constexpr uint32_t moving_frames = 8, frames_before = 2 * SettleMeter::period, dolly_frames = 12;
constexpr float two_codes = 2.0f / 255 / 12.92f;  // of PNG values, in linear light
constexpr double visible = 0.01;                  // FLIP

struct Method {
  const char* variant;
  sideray_ambient ambient;
  bool is_default;
};
constexpr std::array<Method, 2> methods{{{"--ambient bounce", SIDERAY_AMBIENT_BOUNCE, true},
                                         {"--ambient ao", SIDERAY_AMBIENT_AO, false}}};

// Two rooms of 2 x 2 x 3 side by side, without ceilings under a black sky. The left one has a lamp. The wall between
// them has a closed door.
struct Rooms {
  Scene scene = Scene::create().value();
  sideray_instance door = 0, box = 0;
  sideray_light lamp = sideray_light_defaults();
};

sideray_material_desc matt(glm::vec3 color) {
  sideray_material_desc m = sideray_material_defaults();
  for (int c = 0; c < 3; ++c) m.base_color[c] = color[c];
  m.roughness = 1.0f, m.metallic = 0.0f;
  m.double_sided = 1;
  return m;
}

void move(Rooms& rooms, sideray_instance instance, glm::dvec3 by) {
  const double matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, by.x, by.y, by.z};
  rooms.scene.move_instance(instance, matrix);
}

// Adds a plate of the wall between the rooms, from z0 to z1 and y0 to y1, with both sides and all edges.
sideray_instance add_plate(Scene& scene, double z0, double z1, double y0, double y1, double half,
                           const sideray_material_desc& m) {
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? half : -half, i & 2 ? y1 : y0, i & 4 ? z1 : z0);
  const std::array<uint32_t, 36> indices{0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
                                         2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5};
  sideray_instance_desc instance{};
  instance.mesh = add_triangles(scene, corners, indices);
  instance.material = scene.add_material(m);
  for (const int i : {0, 4, 8}) instance.world_from_object[i] = 1.0;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  return scene.add_instances({&instance, 1}).front();
}

Rooms two_rooms() {
  Rooms rooms;
  Scene& scene = rooms.scene;
  const sideray_material_desc white = matt({0.8f, 0.8f, 0.8f}), red = matt({0.8f, 0.1f, 0.1f});
  constexpr double half_door = 0.5 * width_of_door;
  add_quad(scene, {{{{-2, 0, 1.5}, {2, 0, 1.5}, {2, 0, -1.5}, {-2, 0, -1.5}}}}, white, 0);
  for (const double x : {-2.0, 2.0})
    add_quad(scene, {{{{x, 0, 1.5}, {x, 0, -1.5}, {x, 2, -1.5}, {x, 2, 1.5}}}}, white, 0);
  for (const double z : {-1.5, 1.5}) add_quad(scene, {{{{-2, 0, z}, {2, 0, z}, {2, 2, z}, {-2, 2, z}}}}, white, 0);
  // The plates overlap each other, floor and walls, so that no edges coincide.
  add_plate(scene, -1.6, -half_door, -0.1, 2, half_wall, white);
  add_plate(scene, half_door, 1.6, -0.1, 2, half_wall, white);
  add_plate(scene, -1.2 * half_door, 1.2 * half_door, height_of_door, 2, 0.999 * half_wall, white);
  rooms.door =
      add_plate(scene, -1.1 * half_door, 1.1 * half_door, -0.1, 1.1 * height_of_door, 0.998 * half_wall, white);
  rooms.box = add_plate(scene, -0.3, 0.3, 0.001, 0.6, 0.3, red);
  move(rooms, rooms.box, {-1.4, 0, 0.4});
  scene.set_environment(2, 2, std::array<float, 12>{}.data(), 1, 0);
  rooms.lamp.type = SIDERAY_LIGHT_POINT;
  rooms.lamp.position[0] = -1, rooms.lamp.position[1] = 1.7, rooms.lamp.position[2] = -0.3;
  for (float& c : rooms.lamp.intensity) c = 5;
  scene.set_lights({&rooms.lamp, 1});
  scene.commit();
  return rooms;
}

sideray_camera above(double x, double distance) {
  const glm::dvec3 eye(x, distance, 0.1), target(x - 0.2, 0, 0);
  const glm::dmat4 world_from_camera = glm::inverse(glm::lookAt(eye, target, glm::dvec3(0, 1, 0)));
  return camera_at(world_from_camera, glm::degrees(2.0 * std::atan(1.9 / distance)), 0.1);
}

scenes::Image draw(StressStage& stage, Rooms& rooms, const sideray_camera& camera, const Method& method, uint32_t frame) {
  RenderOptions options = sequence_options(stage, method.ambient);
  set_frame(options, frame, frame > 0);
  return image_of(stage.renderer.render(rooms.scene, camera, options).value());
}

// Draws the truth by paths of all bounces.
scenes::Image truth_of(StressStage& stage, Rooms& rooms, const sideray_camera& camera) {
  RenderOptions options = picture_options(stage, SIDERAY_SHADOWS_INEXACT);
  options.picture.samples = 16;
  options.translucency.reset();
  options.reference = sideray_reference_defaults();
  options.reference->bounces = 0;
  options.reference->light_samples = stage.quick ? 16 : 64;
  return image_of(stage.renderer.render(rooms.scene, camera, options).value());
}

struct Change {
  const char* name;
  uint32_t frames;
  bool is_quick;  // also runs in quick tests
  std::function<void(Rooms&, double share)> happen;  // applies this share of the change
};

const std::vector<Change>& changes() {
  static const std::vector<Change> all{
      {"lamp toggled", 1, true,
       [](Rooms& r, double) {
         for (float& c : r.lamp.intensity) c = 1;
         r.scene.set_lights({&r.lamp, 1});
       }},
      {"door opens", moving_frames, true,
       [](Rooms& r, double share) { move(r, r.door, {0, 0, share * 1.1 * width_of_door}); }},
      {"red box slides over a white floor", moving_frames, false,
       [](Rooms& r, double share) { move(r, r.box, {-1.4 + share, 0, 0.4}); }}};
  return all;
}

// Returns how many frames a ghost lasts by averages alone (stress_settling.cpp): 8 samples while something moves, and
// anti-aliasing.
double frames_until(double share_left) {
  return 8.0 + std::log(std::min(share_left, 1.0)) / std::log(0.9);
}

class Rows {
 public:
  Rows(std::vector<StressRow>& rows, const Method& method, Json parameters) : rows_(rows) {
    row_.name = "bounce", row_.variant = method.variant, row_.is_default = method.is_default;
    row_.parameters = std::move(parameters);
  }
  void add(const char* measure, double value, double bound, FailureMap map = {}) {
    row_.measure = measure, row_.value = value, row_.bound = bound, row_.map = std::move(map);
    rows_.push_back(row_);
  }

 private:
  std::vector<StressRow>& rows_;
  StressRow row_;
};

struct Played {
  double half_life = 0;  // of the ghost, in frames
  double at_rest = 0;    // FLIP against the truth
  double at_first = 0;   // the same in the frame in which the change ends
  uint32_t lag = 0;      // frames until the FLIP stays within `visible` of the one at rest
};

Played play(StressStage& stage, const Method& method, const Change& change) {
  Rooms rooms = two_rooms();
  const sideray_camera camera = above(0.0, 5.0);
  uint32_t frame = 0;
  while (frame < frames_before) draw(stage, rooms, camera, method, frame++);
  std::vector<scenes::Image> after;  // the last picture of the change, and those that follow
  for (uint32_t step = 1; step <= change.frames; ++step) {
    change.happen(rooms, static_cast<double>(step) / change.frames);
    rooms.scene.commit();
    after = {draw(stage, rooms, camera, method, frame++)};
  }
  for (uint32_t i = 0; i < SettleMeter::held; ++i) after.push_back(draw(stage, rooms, camera, method, frame++));
  // Drawn last: the truth in between would end the sequence's history.
  const scenes::Image truth = truth_of(stage, rooms, camera);
  SettleMeter settle;
  std::vector<double> flips;
  for (const scenes::Image& picture : after) {
    settle.add(picture);
    flips.push_back(flip(picture, truth));
  }
  Played played{settle.result().half_life, flips.back(), flips.front(), 0};
  for (uint32_t i = 0; i < flips.size(); ++i)
    if (flips[i] > played.at_rest + visible) played.lag = i + 1;
  return played;
}

void add_change(StressStage& stage, const Change& change, std::vector<StressRow>& rows) {
  std::array<Played, methods.size()> played;
  for (size_t i = 0; i < methods.size(); ++i) played[i] = play(stage, methods[i], change);
  for (size_t i = 0; i < methods.size(); ++i) {
    Rows of(rows, methods[i], {{"change", change.name}});
    const double excess = std::max(played[i].at_first - played[i].at_rest, visible);
    of.add("frames until half of a ghost is gone", played[i].half_life, frames_until(0.5));
    of.add("frames until FLIP to paths is within 0.01 of that at rest", played[i].lag, frames_until(visible / excess));
    of.add("FLIP to paths at rest", played[i].at_rest, 0.5 * played[1].at_rest);
  }
}

// The room behind the wall must be black: its only opening is to a black sky.
void add_wall(StressStage& stage, const Method& method, double distance, const scenes::Image& truth, std::vector<StressRow>& rows) {
  Rooms rooms = two_rooms();
  const sideray_camera camera = above(0.3, distance);
  FailureMap map = map_of(stage);
  for (uint32_t frame = 0; frame < 4; ++frame) {
    const scenes::Image seen = draw(stage, rooms, camera, method, frame);
    // All surfaces are white, so that one channel tells.
    const std::vector<float> &values = seen.planes[0].values, &of_truth = truth.planes[0].values;
    for (size_t i = 0; i < map.wrong.size(); ++i)
      map.wrong[i] |= static_cast<uint8_t>(of_truth[i] == 0.0f && values[i] > two_codes);
  }
  const auto wrong = static_cast<double>(std::ranges::count(map.wrong, 1));
  Rows(rows, method, {{"wall_m", 2 * half_wall}, {"eye_m", distance}})
      .add("pixels of a dark room that shine", wrong, 0, std::move(map));
}

void add_walls(StressStage& stage, std::vector<StressRow>& rows) {
  const std::vector<double> distances = swept(stage, {4.0, 12.0, 40.0}, {4.0, 40.0});
  std::vector<scenes::Image> truths;
  for (const double distance : distances) {
    Rooms rooms = two_rooms();
    truths.push_back(truth_of(stage, rooms, above(0.3, distance)));
  }
  for (const Method& method : methods)
    for (size_t i = 0; i < distances.size(); ++i) add_wall(stage, method, distances[i], truths[i], rows);
}

void add_dolly(StressStage& stage, std::vector<StressRow>& rows) {
  Rooms rooms = two_rooms();
  move(rooms, rooms.door, {0, 0, 1.1 * width_of_door});
  rooms.scene.commit();
  std::vector<scenes::Image> truth;
  const auto camera = [](uint32_t frame) { return above(0.02 * frame - 0.2, 5.0); };
  // The first frames of a sequence converge, which is no flicker.
  for (uint32_t frame = 0; frame < dolly_frames; ++frame)
    truth.push_back(truth_of(stage, rooms, camera(frames_before + frame)));
  std::array<double, methods.size()> flicker{};
  for (size_t i = 0; i < methods.size(); ++i) {
    FlickerMeter meter;
    for (uint32_t frame = 0; frame < frames_before + dolly_frames; ++frame) {
      const scenes::Image seen = draw(stage, rooms, camera(frame), methods[i], frame);
      if (frame >= frames_before) meter.add(seen, truth[frame - frames_before]);
    }
    flicker[i] = std::sqrt(2.0 * meter.result().error_energy);
  }
  for (size_t i = 0; i < methods.size(); ++i)
    Rows(rows, methods[i], {{"moves", "eye"}})
        .add("flicker beside paths, root mean square from frame to frame", flicker[i], 1.5 * flicker[1]);
}

}  // namespace

std::vector<StressRow> bounce_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const Change& change : changes())
    if (!stage.quick || change.is_quick) add_change(stage, change, rows);
  add_walls(stage, rows);
  add_dolly(stage, rows);
  return rows;
}

}  // namespace sideray::lab
