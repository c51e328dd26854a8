// Makes the points of default sweeps and the ways that bounds choose between. Only this file knows which values of
// which options are worth comparing; the library says which of them draw the same picture of a scene.
#include <fmt/format.h>
#include <sideray/plan.h>

#include <algorithm>
#include <sideray/sideray.hpp>

#include "lab/chart/configurations.h"

namespace sideray::lab {
namespace {

constexpr size_t most_points = 60;
constexpr size_t most_counted = 8;  // layers and events; stands for more of them too

// Says how much a chart needs a point: from a list that is too long, fine points are removed first.
enum class Detail { baseline, choice, fine };

struct Point {
  Configuration configuration;
  Detail detail;
  bool is_aside;  // bounds do not choose it
};

struct List {
  std::vector<Point> points;
  std::vector<std::string> left_out;

  void add(Detail detail, Configuration configuration) { points.push_back({std::move(configuration), detail, false}); }
  void add_aside(Detail detail, Configuration configuration) {
    points.push_back({std::move(configuration), detail, true});
  }
};

using enum Detail;

Configuration raster(Configuration more = {}) {
  more["translucency"] = "raster";
  return more;
}

Configuration raytraced(const std::string& events, Configuration more = {}) {
  more["translucency"] = "raytraced";
  more["layers"] = events;
  return more;
}

Configuration hybrid(const std::string& layers, Configuration more = {}) {
  more["translucency"] = "hybrid";
  more["layers"] = layers;
  return more;
}

// Returns the counts 1, 2, 4, 8 up to the first that is at least `most`.
std::vector<std::string> counts_up_to(size_t most) {
  std::vector<std::string> counts;
  for (const size_t count : {1, 2, 4, 8}) {
    counts.push_back(std::to_string(count));
    if (count >= most) break;
  }
  return counts;
}

bool has_translucency(const SweepScene& scene) {
  return scene.translucent_objects > 0 || scene.has_particles;
}

bool has_order(const SweepScene& scene) {
  return scene.most_events > 1 || scene.has_particles;
}

// Adds `drawing` with every order of fragments but the usual one.
void add_orders(const SweepScene& scene, const Configuration& drawing, List& list) {
  const auto ordered = [&](const char* order) {
    Configuration configuration = drawing;
    configuration["oit"] = order;
    return configuration;
  };
  list.add_aside(choice, ordered("peel"));
  if (scene.has_fragment_lists) list.add(choice, ordered("abuffer"));
}

void add_raytraced(const SweepScene& scene, List& list) {
  const std::vector<std::string> events = counts_up_to(scene.most_events);
  for (const std::string& count : events) list.add(baseline, raytraced(count));
  if (scene.most_events >= 8) list.add(baseline, raytraced("unlimited"));
  const std::string& some = events[std::min<size_t>(1, events.size() - 1)];
  list.add_aside(choice, raytraced(some, {{"mask", "none"}}));
  list.add_aside(fine, raytraced(some, {{"mask", "stencil"}}));
  if (scene.most_events > 1) list.add_aside(fine, raytraced(events.back(), {{"step", "retrace"}}));
  if (scene.has_particles) list.add(choice, raytraced(events.back(), {{"rt-particles", "on"}}));
}

// Adds layers for other objects than `--ray-traced auto` selects: all, or only those largest on the screen.
void add_selections(const SweepScene& scene, const std::string& layers, List& list) {
  if (scene.traceable_objects != scene.layered_objects) list.add(choice, hybrid(layers, {{"ray-traced", "all"}}));
  for (const size_t count : {1, 4, 16})
    if (count < scene.traceable_objects)
      list.add(choice, hybrid(layers, {{"ray-traced", fmt::format("largest:{}", count)}}));
}

void add_rates(const std::string& layers, List& list) {
  for (const char* rate : {"checkerboard", "interleaved", "quarter"}) {
    list.add(choice, hybrid(layers, {{"cache-rate", rate}}));
    list.add(fine, hybrid(layers, {{"cache-rate", rate}, {"second-wave", "off"}}));
    if (layers != "1") list.add(fine, hybrid("1", {{"cache-rate", rate}}));
  }
}

// Adds full tracing, and more ray reuse than the default.
void add_reuse(const std::string& layers, List& list) {
  list.add(choice, hybrid(layers, {{"ray-reuse", "0"}}));
  list.add(fine, hybrid(layers, {{"ray-reuse", "0.0625"}}));
}

void add_hybrid(const SweepScene& scene, List& list) {
  const std::vector<std::string> counts = counts_up_to(scene.most_layers);
  for (const std::string& count : counts) list.add(baseline, hybrid(count));
  const std::string layers = counts[std::min<size_t>(2, counts.size() - 1)];
  for (const char* mask : {"none", "stencil"}) {
    list.add_aside(choice, hybrid(layers, {{"mask", mask}}));
    if (layers != "1") list.add_aside(fine, hybrid("1", {{"mask", mask}}));
  }
  add_rates(layers, list);
  add_reuse(layers, list);
  list.add(choice, hybrid(layers, {{"whole-pixels", "off"}}));
  for (const char* match : {"nearest", "distance"}) list.add_aside(choice, hybrid(layers, {{"match", match}}));
  if (layers != "1")
    for (const char* step : {"retrace", "listing"}) list.add_aside(fine, hybrid(layers, {{"step", step}}));
  if (has_order(scene)) add_orders(scene, hybrid(layers), list);
  add_selections(scene, layers, list);
  list.add(choice, hybrid(layers, {{"denoise", "off"}}));
}

// Where nothing is rasterized, hybrid traces all surfaces, whatever its options.
void add_translucency_by_rays(const SweepScene& scene, List& list) {
  list.add(baseline, {{"translucency", "off"}});
  if (!has_translucency(scene)) return;
  list.add(baseline, raster());
  list.add(baseline, hybrid("4"));
  list.add(choice, hybrid("4", {{"denoise", "off"}}));
  add_reuse("4", list);
  add_raytraced(scene, list);
}

void add_translucency(const SweepScene& scene, List& list) {
  if (scene.by_rays) return add_translucency_by_rays(scene, list);
  list.add(baseline, raster());
  if (scene.is_sequence) list.add_aside(baseline, raster({{"taa", "off"}}));
  if (!has_translucency(scene)) {
    list.left_out.push_back("translucency: raster only: the scene has no translucent object");
    return;
  }
  list.add(baseline, {{"translucency", "off"}});
  if (has_order(scene))
    add_orders(scene, raster(), list);
  else
    list.left_out.push_back("translucency: one order of fragments: no ray hits two translucent surfaces");
  if (has_order(scene) && !scene.has_fragment_lists)
    list.left_out.push_back("translucency: no --oit abuffer: it needs OpenGL 4.3");
  if (scene.layered_objects > 0)
    add_hybrid(scene, list);
  else
    list.left_out.push_back(
        "translucency: no hybrid: --ray-traced auto gives layers to none of the scene's translucent objects");
  if (scene.layered_objects > 0 && scene.is_sequence) list.add_aside(baseline, {{"taa", "off"}});
  if (std::min(scene.most_layers, scene.most_events) < 8)
    list.left_out.push_back(fmt::format("translucency: no more layers than a ray can hit, {}, nor events than {}",
                                        scene.most_layers, scene.most_events));
  add_raytraced(scene, list);
  // The reference averages no frames of a sequence, so it takes 8 positions in each pixel instead.
  if (scene.is_sequence)
    list.add_aside(baseline, {{"translucency", "reference"}, {"samples", "8"}});
  else
    list.add_aside(baseline, {{"translucency", "reference"}});
}

Configuration exact(Configuration more = {}) {
  more["shadows"] = "exact";
  return more;
}

Configuration inexact(const std::string& variant, Configuration more = {}) {
  more["shadows"] = "inexact";
  more["inexact"] = variant;
  return more;
}

// Adds the poses that rays hit, with each shadow test that allows for a drawn pose different from the hit one.
void add_poses(const SweepScene& scene, List& list) {
  const Configuration still{{"poses", "rest"}}, one{{"poses", "1"}}, four{{"poses", "4"}}, own{{"poses", "all"}};
  list.add(baseline, exact(still));
  if (scene.swaying_copies > 1) list.add(choice, exact(four));
  list.add(baseline, exact(own));
  list.add(baseline, inexact("restpose", still));
  list.add(baseline, inexact("restpose"));
  if (scene.swaying_copies > 1) list.add(choice, inexact("restpose", four));
  if (scene.swaying_copies > 4) {
    list.add(fine, exact(one));
    list.add(fine, inexact("restpose", one));
  }
  list.add(choice, inexact("bounded", still));
  list.add(choice, inexact("bounded"));
  for (const char* bias : {"0.1", "0.25", "1"})
    list.add(fine, inexact("tmin", {{"poses", "rest"}, {"inexact-bias", bias}}));
  list.add(baseline, inexact("tmin", still));
  list.add(choice, inexact("tmin"));
  list.add(fine, inexact("tmin", {{"poses", "rest"}, {"inexact-target", "bit"}}));
  list.add(choice, exact({{"poses", "rest"}, {"denoise", "off"}}));
  list.add(choice, exact({{"poses", "all"}, {"denoise", "off"}}));
  list.add(choice, inexact("tmin", {{"poses", "rest"}, {"denoise", "off"}}));
}

void add_inexact(const SweepScene& scene, List& list) {
  if (scene.swaying_objects > 0)
    add_poses(scene, list);
  else
    list.left_out.push_back("shadows: one pose and no inexact shadows of what moves: wind moves nothing");
  if (!scene.has_cut_outs) return;
  for (const char* bias : {"0.1", "0.5"})
    list.add(choice, inexact("tmin", {{"poses", "rest"}, {"inexact-target", "model"}, {"inexact-bias", bias}}));
}

// Adds angles below which instances are removed from the acceleration structure, where any instance looks that small.
void add_culling(const SweepScene& scene, List& list) {
  for (const int angle : {1, 2, 4, 8})
    if (scene.smallest_angle_deg < angle) list.add(angle == 4 ? fine : choice, {{"cull-angle", std::to_string(angle)}});
  if (scene.smallest_angle_deg >= 8)
    list.left_out.push_back(
        fmt::format("shadows: one --cull-angle: nothing looks smaller than {:.3g} degrees", scene.smallest_angle_deg));
}

const char* rays_for(const SweepScene& scene) {
  return scene.swaying_objects > 0 ? "inexact" : "exact";
}

// Adds indirect light.
void add_indirect(const SweepScene& scene, List& list) {
  std::vector<const char*> shadows{"off"};
  if (scene.lights > 0) shadows = {"map", rays_for(scene)};
  if (scene.has_gloss)
    for (const char* kind : shadows)
      for (const char* traced : {"on", "off"}) list.add_aside(choice, {{"shadows", kind}, {"reflections", traced}});
  else
    list.left_out.push_back("shadows: no --reflections on: no opaque surface is smooth enough");
  if (!scene.has_environment) {
    list.left_out.push_back("shadows: no --ambient ao: it darkens the light of the environment, and there is none");
    return;
  }
  for (const char* kind : shadows)
    for (const char* traced : {"bounce", "ao", "off"}) list.add_aside(choice, {{"shadows", kind}, {"ambient", traced}});
  list.add_aside(fine, {{"shadows", shadows.back()}, {"ambient", "ao"}, {"denoise", "off"}});
  if (scene.has_gloss) list.add_aside(fine, {{"shadows", shadows.back()}, {"ambient", "ao"}, {"reflections", "on"}});
}

void add_shadows(const SweepScene& scene, List& list) {
  list.add(baseline, {{"shadows", "off"}});
  if (scene.lights > 0) {
    list.add(baseline, {{"shadows", "map"}});
    if (scene.is_sequence) {
      list.add_aside(baseline, {{"shadows", "map"}, {"taa", "off"}});
      list.add_aside(baseline, {{"shadows", rays_for(scene)}, {"taa", "off"}});
      list.add_aside(choice, {{"shadows", rays_for(scene)}, {"taa", "off"}, {"denoise", "off"}});
    }
    list.add(baseline, exact());
    add_inexact(scene, list);
    list.add(choice, exact({{"denoise", "off"}}));
    add_culling(scene, list);
  } else {
    list.left_out.push_back("shadows: no visibility of lights: no light of the scene sends any");
  }
  add_indirect(scene, list);
}

sideray_scene_facts facts_of(const SweepScene& scene) {
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  facts.translucent_objects = scene.translucent_objects;
  facts.traceable_objects = scene.traceable_objects;
  facts.layered_objects = scene.layered_objects;
  facts.most_layers = scene.most_layers < most_counted ? scene.most_layers : SIDERAY_UNBOUNDED;
  facts.most_surfaces = scene.most_events < most_counted ? scene.most_events : SIDERAY_UNBOUNDED;
  facts.sprites = scene.has_particles;
  facts.lit_lights = scene.lights;
  facts.swaying_objects = scene.swaying_objects;
  facts.swaying_copies = scene.swaying_copies;
  facts.inexact_objects[SIDERAY_TARGET_MODEL] = scene.has_cut_outs;
  for (const auto target : {SIDERAY_TARGET_BIT, SIDERAY_TARGET_STENCIL})
    facts.inexact_objects[target] = scene.swaying_objects;
  facts.glossy_objects = scene.has_gloss;
  facts.has_environment = scene.has_environment;
  facts.auto_ao = scene.auto_ao;
  facts.auto_bounce = scene.auto_bounce;
  facts.auto_reflections = scene.auto_reflections;
  return facts;
}

// Returns the options of a configuration without those that change nothing in such a scene.
Options reduced(const Configuration& configuration, const SweepScene& scene, const sideray_scene_facts& facts) {
  Options options = Options::create().value();
  if (scene.is_sequence) options.set("taa", "on");
  for (const auto& [option, value] : configuration) options.set(option, value);
  check([&](sideray_error* error) { return sideray_options_reduce(options.get(), &facts, error); });
  return options;
}

void leave_out_doubles(const SweepScene& scene, std::vector<Point>& points) {
  const sideray_scene_facts facts = facts_of(scene);
  std::vector<Point> kept;
  std::vector<Options> said;
  for (Point& point : points) {
    Options says = reduced(point.configuration, scene, facts);
    const auto is_same = [&](const Options& other) { return sideray_options_equal(other.get(), says.get()) != 0; };
    if (std::any_of(said.begin(), said.end(), is_same)) continue;
    said.push_back(std::move(says));
    kept.push_back(std::move(point));
  }
  points = std::move(kept);
}

// Removes the least needed points of a list that is too long; the others stay in order.
void leave_out_details(List& list) {
  if (list.points.size() <= most_points) return;
  std::vector<size_t> order;
  for (const Detail detail : {baseline, choice, fine})
    for (size_t i = 0; i < list.points.size(); ++i)
      if (list.points[i].detail == detail) order.push_back(i);
  list.left_out.push_back(fmt::format("{} of {} points: the finest are in --sweep translucency and --sweep shadows",
                                      most_points, list.points.size()));
  order.resize(most_points);
  std::sort(order.begin(), order.end());
  std::vector<Point> kept;
  for (const size_t i : order) kept.push_back(std::move(list.points[i]));
  list.points = std::move(kept);
}

}  // namespace

DefaultSweep default_sweep(Sweep sweep, const SweepScene& scene) {
  List list;
  if (sweep != Sweep::shadows) add_translucency(scene, list);
  if (sweep != Sweep::translucency) add_shadows(scene, list);
  leave_out_doubles(scene, list.points);
  leave_out_details(list);
  DefaultSweep result;
  for (Point& point : list.points) {
    if (!point.is_aside) result.choices.push_back(point.configuration);
    result.configurations.push_back(std::move(point.configuration));
  }
  result.left_out = std::move(list.left_out);
  return result;
}

std::vector<Way> ways_to_draw(const SweepScene& scene) {
  if (!has_translucency(scene)) return {};
  std::vector<Way> ways;
  if (scene.by_rays)
    ways.push_back({{"translucency", {"hybrid"}}, {"layers", {"4"}}});
  else if (scene.layered_objects > 0)
    ways.push_back({{"translucency", {"hybrid"}},
                    {"layers", {"4", "1", "2", "8"}},
                    {"cache-rate", {"full", "checkerboard", "quarter"}}});
  ways.push_back({{"translucency", {"raster"}}});
  ways.push_back({{"translucency", {"raytraced"}}, {"layers", {"1", "2", "4", "8", "unlimited"}}});
  ways.push_back({{"translucency", {"off"}}});
  return ways;
}

std::vector<Way> ways_to_shadow(const SweepScene& scene) {
  if (scene.lights == 0) return {};
  std::vector<std::string> kinds{"exact", "map", "off"};
  if (scene.swaying_objects > 0) kinds.insert(kinds.begin(), "inexact");
  return {{{"shadows", kinds}}};
}

}  // namespace sideray::lab
