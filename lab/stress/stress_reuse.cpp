// Measures light that layers keep from the frames before: how long a picture shows what was, after lamps, occluders,
// glass and the view have changed. Every frame drawn as a picture of its own is the oracle.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

struct Method {
  const char* variant;
  float shading_reuse;
  sideray_cache_rate rate;
  float off;  // radiance by which a layer may be wrong in its pixel
  bool is_default, is_quick;
};
constexpr float automatic = 0x1p-8f;
constexpr std::array<Method, 5> methods{
    {{"--shading-reuse 0", 0.0f, SIDERAY_RATE_FULL, 0.0f, true, true},
     {"--shading-reuse auto", SIDERAY_SHADING_REUSE_AUTO, SIDERAY_RATE_FULL, automatic, false, true},
     {"--shading-reuse 0.0625", 0x1p-4f, SIDERAY_RATE_FULL, 0x1p-4f, false, false},
     {"--cache-rate temporal4", 0.0f, SIDERAY_RATE_TEMPORAL4, automatic, false, false},
     {"--cache-rate temporal8", 0.0f, SIDERAY_RATE_TEMPORAL8, automatic, false, true}}};

constexpr uint32_t layers = 2;
constexpr double fov_deg = 45.0, pane_depth = 2.0, lamp_depth = 2.0, card_depth = 0.3;
// Everything rests so long before the change and after it: longer than all take to have their turn.
constexpr uint32_t frames_before = 10, frames_after = 12, frames_moving = 12;

double pixel_at(double depth, const StressStage& stage) {
  return 2.0 * depth * std::tan(0.5 * glm::radians(fov_deg)) / stage.height;
}

sideray_material_desc smooth_glass(float metallic) {
  sideray_material_desc m = sideray_material_defaults();
  m.alpha_mode = SIDERAY_BLEND;
  m.double_sided = 1;
  m.metallic = metallic;
  m.roughness = 0.0f;
  m.base_color[0] = 0.9f, m.base_color[1] = 0.8f, m.base_color[2] = 0.7f, m.base_color[3] = 0.5f;
  return m;
}

sideray_material_desc glowing(float radiance) {
  sideray_material_desc m = sideray_material_defaults();
  m.double_sided = 1;
  m.specular = 0.0f;
  for (size_t c = 0; c < 3; ++c) m.base_color[c] = 0.0f, m.emissive[c] = radiance;
  return m;
}

Pane upright(double x, double z, double half_width, double half_height) {
  return {{{{x - half_width, -half_height, z},
            {x + half_width, -half_height, z},
            {x + half_width, half_height, z},
            {x - half_width, half_height, z}}}};
}

// Two panes before the eye, a matt one and a mirror. Behind the eye are a lamp, stripes of light that the panes mirror,
// and a card whose shadow falls on them.
struct Room {
  Scene scene = Scene::create().value();
  sideray_instance card, turning;
  sideray_camera camera = camera_at(glm::dmat4(1.0), fov_deg, 0.05);

  // `card_width`, `card_x`: of its shadow on the matt pane.
  Room(double card_width, double card_x) {
    turning = add_quad(scene, upright(0, 0, 1.2, 0.8), smooth_glass(0.0f), 1);
    move(turning, place(0));
    add_quad(scene, upright(0, -3, 12, 12), smooth_glass(1.0f), 2);
    for (int i = -10; i <= 10; ++i)
      add_quad(scene, upright(0.8 * i, 4, 0.2, 6), glowing(0.5f + 0.03f * static_cast<float>(i)), 3);
    // From the lamp's place all grows from the card's depth to the pane's.
    const double growth = (lamp_depth + pane_depth) / (lamp_depth - card_depth);
    card = add_quad(scene, upright(0, 0, 0.5 * card_width / growth, 0.5 * card_width / growth), glowing(0.0f), 4);
    move_card(card_x);
    set_lamp(1.0, 20.0f);
    scene.commit();
  }
  static glm::dmat4 place(double angle_deg) {
    return glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -pane_depth)), glm::radians(angle_deg),
                       glm::dvec3(0, 1, 0));
  }
  void move(sideray_instance instance, const glm::dmat4& world_from_object) {
    double rows[12];
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) rows[3 * column + row] = world_from_object[column][row];
    scene.move_instance(instance, rows);
  }
  // To where its shadow's middle is at `x` on the matt pane.
  void move_card(double x) {
    const double share = (lamp_depth - card_depth) / (lamp_depth + pane_depth);
    const glm::dvec3 lamp(1.0, 1.5, lamp_depth), shadow(x, 0, -pane_depth);
    move(card, glm::translate(glm::dmat4(1.0), lamp + share * (shadow - lamp)));
  }
  void set_lamp(double x, float intensity) {
    sideray_light lamp = sideray_light_defaults();
    lamp.type = SIDERAY_LIGHT_POINT;
    lamp.position[0] = x, lamp.position[1] = 1.5, lamp.position[2] = lamp_depth;
    for (float& c : lamp.intensity) c = intensity;
    scene.set_lights({&lamp, 1});
  }
};

// What a picture may lag behind: the bounds of docs/adr/0029-shading-reuse.md, from the first frame at rest on. What
// slides or turns is held to the same two frames, though the last of its steps may change less than 12 pixels.
struct Promise {
  uint32_t frames_off;    // frames that show a pixel off by more than the method says
  uint32_t frames_apart;  // frames that have another bit than full shading
};
constexpr Promise at_once{0, 0}, found_soon{2, 8}, within_a_period{8, 8};

struct Change {
  const char* name;
  const char* parameter;  // "": none
  double amount;
  Promise promise;
  uint32_t frames;            // that it goes on for; it rests from the last of them on
  double card_width, card_x;  // at first, in pixels
  std::function<void(Room&, double frames, double pixel)> change;  // to what it is after so many frames
  bool is_cut = false;
};

std::vector<Change> changes(const StressStage& stage) {
  std::vector<Change> list;
  const auto add = [&](Change change) { list.push_back(std::move(change)); };
  const auto at_frame = [&](const char* name, Promise promise, auto change, bool is_cut = false) {
    add({name, "", 0.0, promise, 1, 16, 0, change, is_cut});
  };
  at_frame("lamp goes out", at_once, [](Room& r, double, double) { r.set_lamp(1.0, 0.0f); });
  at_frame("lamp moves", at_once, [](Room& r, double, double) { r.set_lamp(0.8, 20.0f); });
  const auto look_from = [](Room& r, double x) {
    r.camera = camera_at(glm::translate(glm::dmat4(1.0), glm::dvec3(x, 0, 0)), fov_deg, 0.05);
  };
  at_frame(
      "cut", at_once, [=](Room& r, double, double) { look_from(r, 0.3); }, true);
  at_frame("jump without a cut", found_soon, [=](Room& r, double, double) { look_from(r, 0.3); });
  constexpr double away = 1e4;
  for (const double width : swept(stage, {1, 2, 4, 8, 12, 16, 32}, {1, 12})) {
    const Promise promise = width < 12 ? within_a_period : found_soon;
    add({"occluder comes", "pixels", width, promise, 1, width, away, [](Room& r, double, double) { r.move_card(0); }});
    add({"occluder goes", "pixels", width, promise, 1, width, 0,
         [](Room& r, double, double pixel) { r.move_card(away * pixel); }});
  }
  for (const double speed : swept(stage, {0.3, 1, 3, 10}, {1, 10}))
    add({"occluder slides", "pixels_a_frame", speed, found_soon, frames_moving, 16, 0,
         [=](Room& r, double frames, double pixel) { r.move_card(speed * frames * pixel); }});
  for (const double speed : swept(stage, {0.1, 0.3, 1, 3, 10}, {1}))
    add({"glass turns", "degrees_a_frame", speed, found_soon, frames_moving, 16, 0,
         [=](Room& r, double frames, double) { r.move(r.turning, Room::place(speed * frames)); }});
  return list;
}

using Colours = std::vector<float>;  // R, G and B of all pixels

// Draws all frames, each as a picture that follows the one before, or alone and shaded in full.
std::vector<Colours> play(StressStage& stage, const Change& change, const Method& method, bool is_alone) {
  const double pixel = pixel_at(pane_depth, stage);
  Room room(change.card_width * pixel, change.card_x * pixel);
  RenderOptions options = picture_options(stage, SIDERAY_SHADOWS_MAP);
  options.translucency->layers = layers;
  options.translucency->shading_reuse = is_alone ? 0.0f : method.shading_reuse;
  options.translucency->cache_rate = method.rate;
  std::vector<Colours> pictures;
  for (uint32_t frame = 0; frame < frames_before + change.frames + frames_after; ++frame) {
    const uint32_t moved = frame < frames_before ? 0 : std::min(frame - frames_before + 1, change.frames);
    if (frame >= frames_before) change.change(room, moved, pixel), room.scene.commit();
    options.picture.continues = !is_alone && frame > 0 && !(change.is_cut && frame == frames_before);
    const Picture picture = stage.renderer.render(room.scene, room.camera, options).value();
    const Planes planes(picture);
    Colours colours;
    for (const char* name : {"R", "G", "B"})
      colours.insert(colours.end(), planes.floats(name), planes.floats(name) + planes.pixels());
    pictures.push_back(std::move(colours));
  }
  return pictures;
}

// Marks the pixels off by more than so much, and by what the picture's halfs round.
FailureMap wrong(const StressStage& stage, const Colours& shown, const Colours& full, float off) {
  FailureMap map = map_of(stage);
  for (size_t i = 0; i < full.size(); ++i)
    map.wrong[i % map.wrong.size()] |= std::abs(shown[i] - full[i]) > off + (off > 0.0f ? 0x1p-10f * full[i] : 0.0f);
  return map;
}

size_t count(const FailureMap& map) {
  return static_cast<size_t>(std::count(map.wrong.begin(), map.wrong.end(), uint8_t{1}));
}

void add_rows(StressStage& stage, const Change& change, const Method& method, const std::vector<Colours>& full,
              std::vector<StressRow>& rows) {
  const std::vector<Colours> shown = play(stage, change, method, false);
  StressRow row;
  row.name = "reused-shading", row.variant = method.variant, row.is_default = method.is_default;
  row.parameters = {{"change", change.name}};
  if (*change.parameter) row.parameters[change.parameter] = change.amount;
  const auto add = [&](const char* measure, double value, double bound, FailureMap map) {
    row.measure = measure, row.value = value, row.bound = bound, row.map = std::move(map);
    rows.push_back(row);
  };
  // Each layer may be off.
  const auto map_at = [&](uint32_t frame) { return wrong(stage, shown[frame], full[frame], layers * method.off); };
  const uint32_t rests = frames_before + change.frames - 1, end = static_cast<uint32_t>(full.size());
  uint32_t frames_off = 0, frames_apart = 0;
  for (uint32_t frame = rests; frame < end; ++frame) {
    if (count(map_at(frame)) > 0) frames_off = frame - rests + 1;
    if (shown[frame] != full[frame]) frames_apart = frame - rests + 1;
  }
  const bool keeps = method.off > 0.0f;
  add("frames until no pixel is off by more than E a layer", frames_off, keeps ? change.promise.frames_off : 0,
      map_at(rests));
  add("frames until every bit is that of full shading", frames_apart, keeps ? change.promise.frames_apart : 0, {});
  if (change.frames == 1) return;
  // What moves on is found as what has moved.
  FailureMap worst = map_of(stage);
  for (uint32_t frame = frames_before + found_soon.frames_off; frame < rests; ++frame)
    if (FailureMap map = map_at(frame); count(map) > count(worst)) worst = std::move(map);
  const double share = static_cast<double>(count(worst)) / static_cast<double>(worst.wrong.size());
  add("pixels off by more than E a layer while it moves, share in the worst frame", share, 0.0, std::move(worst));
}

}  // namespace

std::vector<StressRow> reused_shading_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const Change& change : changes(stage)) {
    std::map<sideray_cache_rate, std::vector<Colours>> full;
    for (const Method& method : methods) {
      if (stage.quick && !method.is_quick) continue;
      std::vector<Colours>& of_rate = full[method.rate];
      if (of_rate.empty()) of_rate = play(stage, change, method, true);
      add_rows(stage, change, method, of_rate, rows);
    }
  }
  return rows;
}

}  // namespace sideray::lab
