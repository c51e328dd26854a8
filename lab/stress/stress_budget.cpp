// Tests pictures under a budget after a change, against pictures that trace everything in each frame. The budget is
// counted in pieces, so that rows have the same bits everywhere. With P of N pieces a frame, everything has been traced
// after K = ceil(N / P) frames. The first such turn replaces the old content; then each turn adds a sample position to
// a view at rest, as each frame does without a budget. So the picture may converge K times more slowly, a turn later,
// but must not be more wrong than that. The same holds in turns: a budget too short for any job traces one piece of one
// job a frame, whatever the clock says.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <sideray/diagnostics.h>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

constexpr double visible = 1.0 / 255;  // mean FLIP
constexpr uint32_t tile = 32;          // side of a piece in pixels
constexpr uint32_t width = 96, height = 54;  // with fewer pixels noise exceeds the bound
constexpr uint32_t moving_frames = 8;  // duration of changes that move something
constexpr uint32_t settled = 70;       // frames at rest after which a fully traced picture no longer changes
constexpr std::array<uint32_t, 3> turns{2, 4, 8};  // number of turns after which pictures are compared
constexpr float no_time = 0.001f;                  // milliseconds: too short for any job
constexpr uint32_t jobs = 4;                       // masks, bounced light, reflections and layers

// A room without a ceiling: floor and wall, a card under two lamps, a reflecting pane, smoke, a plant in the wind.
struct World {
  Scene scene = Scene::create().value();
  sideray_instance card = 0, pane = 0;
  sideray_particles smoke = 0;
  std::vector<sideray_light> lamps;
  glm::dmat4 world_from_camera{1.0};
  uint32_t width = 0, height = 0;
  uint32_t pieces = 0;    // of each job in a frame; 0 = no such budget
  bool in_turns = false;  // one piece of one job in a frame
  bool continues = true;
};

Pane upright(double x, double z, double half_width, double tall) {
  return {{{{x - half_width, 0, z}, {x + half_width, 0, z}, {x + half_width, tall, z}, {x - half_width, tall, z}}}};
}

void place(World& world, sideray_instance instance, const glm::dmat4& where) {
  double matrix[12];
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) matrix[3 * column + row] = where[column][row];
  world.scene.move_instance(instance, matrix);
}

void set_smoke(World& world, double z, double rise) {
  std::vector<sideray_sprite> sprites;
  for (int i = 0; i < 12; ++i) {
    sideray_sprite sprite{};
    const double turn = 2.4 * i;
    sprite.position[0] = 0.9 + 0.35 * std::cos(turn), sprite.position[1] = 0.3 + 0.12 * i + rise;
    sprite.position[2] = z + 0.1 * std::sin(turn);
    sprite.width = sprite.height = 0.5f;
    sprite.color[0] = sprite.color[1] = sprite.color[2] = 0.6f, sprite.color[3] = 0.25f;
    sprites.push_back(sprite);
  }
  world.scene.set_sprites(world.smoke, sprites);
}

sideray_light lamp_at(glm::dvec3 place, float intensity) {
  sideray_light lamp = sideray_light_defaults();
  lamp.type = SIDERAY_LIGHT_POINT;
  for (int i = 0; i < 3; ++i) lamp.position[i] = place[i], lamp.intensity[i] = intensity;
  lamp.radius = 0.08f;
  return lamp;
}

World world_of(uint32_t pieces, bool in_turns = false) {
  World world;
  world.width = width, world.height = height, world.pieces = pieces, world.in_turns = in_turns;
  sideray_material_desc matt = sideray_material_defaults(), smooth = matt, glass = matt;
  matt.double_sided = smooth.double_sided = glass.double_sided = 1;
  smooth.roughness = 0.15f;
  for (float& c : smooth.base_color) c = 0.6f;
  smooth.base_color[3] = 1.0f;
  glass.alpha_mode = SIDERAY_BLEND;
  glass.roughness = 0.0f;
  for (int i = 0; i < 3; ++i) glass.base_color[i] = i == 0 ? 0.3f : 0.7f;
  glass.base_color[3] = 0.35f;
  constexpr double half = 5.0;
  Scene& scene = world.scene;
  add_quad(scene, {{{{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}}}}, smooth, 1);
  add_quad(scene, upright(0, -3, half, 4), matt, 2);
  world.card = add_quad(scene, {{{{-0.6, 1.6, 0.6}, {0.6, 1.6, 0.6}, {0.6, 1.6, -0.6}, {-0.6, 1.6, -0.6}}}}, matt, 3);
  world.pane = add_quad(scene, upright(0, 0, 0.7, 1.6), glass, 4);
  sideray_wind_desc wind = sideray_wind_defaults();
  wind.direction[0] = 1, wind.direction[1] = wind.direction[2] = 0;
  wind.amplitude = 0.5f, wind.frequency = 0.7f, wind.height = 1.8f;
  add_quad(scene, upright(-1.6, -1.0, 0.25, 1.8), matt, 5, scene.add_wind(wind));
  world.smoke = scene.add_particles(sideray_particles_defaults());
  set_smoke(world, 0.6, 0);
  world.lamps = {lamp_at({-2, 3.5, 1.5}, 14), lamp_at({2.2, 3.0, 2.0}, 10)};
  scene.set_lights(world.lamps);
  place(world, world.card, glm::translate(glm::dmat4(1.0), glm::dvec3(-0.9, 0, -0.6)));
  place(world, world.pane, glm::translate(glm::dmat4(1.0), glm::dvec3(0.9, 0, 0)));
  world.world_from_camera = glm::inverse(glm::lookAt(glm::dvec3(0, 2.2, 5.2), glm::dvec3(0, 0.8, 0), glm::dvec3(0, 1, 0)));
  scene.commit();
  return world;
}

// Changes a world in frame `step` of a change, starting at 0.
struct Change {
  const char* name;
  uint32_t frames;
  bool keeps_past;  // pictures may show earlier frames
  bool is_quick;    // also runs in quick tests
  std::function<void(World&, uint32_t step)> happen;
};

const std::vector<Change>& changes() {
  static const std::vector<Change> all{
      {"lamp toggled", 1, true, false,
       [](World& w, uint32_t) {
         for (float& c : w.lamps[1].intensity) c = 0;
         w.scene.set_lights(w.lamps);
       }},
      {"lamp moved", 1, true, true,
       [](World& w, uint32_t) {
         w.lamps[0].position[0] += 1.2;
         w.scene.set_lights(w.lamps);
       }},
      {"occluder moved", 1, true, true,
       [](World& w, uint32_t) { place(w, w.card, glm::translate(glm::dmat4(1.0), glm::dvec3(0.1, 0, -0.2))); }},
      {"glass spins", moving_frames, true, false,
       [](World& w, uint32_t step) {
         const glm::dmat4 there = glm::translate(glm::dmat4(1.0), glm::dvec3(0.9, 0, 0));
         place(w, w.pane, glm::rotate(there, glm::radians(7.0 * (step + 1)), glm::dvec3(0, 1, 0)));
       }},
      {"cut", 1, false, true,
       [](World& w, uint32_t) {
         w.continues = false;
         w.world_from_camera =
             glm::inverse(glm::lookAt(glm::dvec3(2.5, 1.6, 4.2), glm::dvec3(0, 0.8, 0), glm::dvec3(0, 1, 0)));
       }},
      {"smoke before glass rises", moving_frames, true, false, [](World& w, uint32_t step) { set_smoke(w, 0.6, 0.05 * (step + 1)); }},
      {"smoke goes behind glass", moving_frames, true, false, [](World& w, uint32_t step) { set_smoke(w, -0.6, 0.05 * (step + 1)); }},
      {"wind", moving_frames, true, false, [](World& w, uint32_t step) { w.scene.set_time((step + 1) / 30.0, step / 30.0); }},
      {"picture grows", 1, false, false, [](World& w, uint32_t) { w.width *= 2, w.height *= 2; }},
      {"budget shrinks and grows", moving_frames, true, false, [](World& w, uint32_t step) {
         if (w.pieces > 0) w.pieces = step % 2 == 0 ? 1 : 25;
         place(w, w.card, glm::translate(glm::dmat4(1.0), glm::dvec3(0.1 * (step + 1) - 0.9, 0, -0.6)));
       }}};
  return all;
}

scenes::Image draw(StressStage& stage, World& world, uint32_t frame) {
  RenderOptions options = sequence_options({stage.renderer, stage.quick, world.width, world.height, stage.by_rays});
  set_frame(options, frame, frame > 0 && world.continues);
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  diagnostics.budget_pieces = world.pieces;
  options.picture.budget_ms = world.in_turns ? no_time : 0.0f;
  options.picture.diagnostics = &diagnostics;
  world.continues = true;
  return image_of(stage.renderer.render(world.scene, camera_at(world.world_from_camera, 50.0, 0.1), options).value());
}

// Pictures of a world before, during and after a change.
struct Play {
  scenes::Image before;
  std::vector<scenes::Image> after;  // the first is the last frame of the change
};

Play play(StressStage& stage, World world, const Change& change, uint32_t frames_before, uint32_t frames_after) {
  Play seen;
  uint32_t frame = 0;
  while (frame < frames_before) seen.before = draw(stage, world, frame++);
  for (uint32_t step = 0; step < change.frames; ++step) {
    const uint32_t pieces = world.pieces;
    change.happen(world, step);
    world.scene.commit();
    scenes::Image image = draw(stage, world, frame++);
    if (step + 1 == change.frames) seen.after.push_back(std::move(image)), world.pieces = std::min(pieces, world.pieces);
  }
  while (seen.after.size() < frames_after) {
    // The wind stops.
    if (change.frames > 1) world.scene.set_time(moving_frames / 30.0, moving_frames / 30.0), world.scene.commit();
    seen.after.push_back(draw(stage, world, frame++));
  }
  return seen;
}

// A budget, and how many frames it takes to trace everything once.
struct Limit {
  const char* variant;
  uint32_t pieces;
  bool in_turns;
  uint32_t frames(uint32_t all) const { return in_turns ? jobs * all : (all + pieces - 1) / pieces; }
};

std::vector<Limit> limits(const StressStage& stage, const Change& change) {
  std::vector<Limit> found;
  for (const double pieces : swept(stage, {1, 2}, {1}))
    found.push_back({"--budget, in pieces", static_cast<uint32_t>(pieces), false});
  // Turns take four times as many frames. Of the quick changes only the cut is drawn in turns.
  if (!stage.quick || !change.keeps_past) found.push_back({"--budget, in turns", 0, true});
  return found;
}

// Compares a change under each budget with the same change without one.
void test_change(StressStage& stage, const Change& change, std::vector<StressRow>& rows) {
  World ends = world_of(0);
  for (uint32_t step = 0; step < change.frames; ++step) change.happen(ends, step);
  const uint32_t all = (ends.width + tile - 1) / tile * ((ends.height + tile - 1) / tile);
  const Play full = play(stage, world_of(0), change, 16, std::max(turns.back() * all + 1, settled));
  const scenes::Image& truth = full.after.back();
  for (const Limit& limit : limits(stage, change)) {
    const bool is_brief = stage.quick && limit.in_turns;
    const uint32_t slower = limit.frames(all), before = is_brief ? slower : 4 * slower;
    const uint32_t most_turns = is_brief ? turns.front() : turns.back();
    const Play budgeted = play(stage, world_of(limit.pieces, limit.in_turns), change, before, most_turns * slower + 1);
    StressRow row;
    // A budget too short for any job shows late what moves: its rows are required only where no history may be shown.
    row.name = "budget", row.variant = limit.variant, row.is_default = !limit.in_turns || !change.keeps_past;
    row.parameters = {{"change", change.name}, {"pieces", std::max(limit.pieces, 1u)}, {"of", all}};
    row.bound = visible;
    const auto add = [&](const std::string& measure, double value) {
      row.measure = measure, row.value = value;
      rows.push_back(row);
    };
    if (change.keeps_past)
      add("FLIP beyond that of the picture before, as it ends",
          flip(budgeted.after[0], truth) - flip(full.before, truth));
    add("FLIP beyond that of the frame in which it ends, after 1 turn",
        flip(budgeted.after[slower], truth) - flip(budgeted.after[0], truth));
    for (const uint32_t n : turns) {
      if (n > most_turns) break;
      double slow = 0;
      for (size_t k = n - 2; k < full.after.size(); ++k) slow = std::max(slow, flip(full.after[k], truth));
      add(fmt::format("FLIP beyond that of full tracing, as many times slower and a turn later, after {} turns", n),
          flip(budgeted.after[n * slower], truth) - slow);
    }
  }
}

}  // namespace

std::vector<StressRow> budget_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const Change& change : changes())
    if (!stage.quick || change.is_quick) test_change(stage, change, rows);
  return rows;
}

}  // namespace sideray::lab
