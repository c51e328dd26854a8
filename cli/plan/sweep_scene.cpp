#include "cli/plan/sweep_scene.h"

#include <sideray/plan.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include "scenes/content/placement.h"

namespace sideray::cli {
namespace {

using scenes::Content;
using scenes::Object;

constexpr uint64_t most_layers = 8;

// Returns the angle of the sphere around an object's box; 180 from inside.
double angle_deg(const Content& content, const Object& object, const sideray_camera& camera) {
  const scenes::Bounds bounds = scenes::bounds_of(content, object);
  if (bounds.empty()) return 180;
  const double* m = camera.world_from_camera;
  const double distance = glm::distance(0.5 * (bounds.minimum + bounds.maximum), glm::dvec3(m[9], m[10], m[11]));
  const double radius = 0.5 * glm::distance(bounds.minimum, bounds.maximum);
  return radius >= distance ? 180 : 2 * std::asin(radius / distance) * 180 / std::numbers::pi;
}

// Returns the smallest angle, in terms of --cull-angle in this view. In orthographic views nothing is too far away.
double smallest_angle_deg(const Content& content, const sideray_camera& camera) {
  double smallest = 180;
  const double per_degree = sideray_plan_cull_angle(&camera, 1.0f);
  if (!(per_degree > 0)) return smallest;
  for (const Object& object : content.objects)
    smallest = std::min(smallest, angle_deg(content, object, camera) / per_degree);
  return smallest;
}

bool is_at_least(const std::string& version, int major, int minor) {
  int found_major = 0, found_minor = 0;
  const char* end = version.data() + version.size();
  const auto [dot, error] = std::from_chars(version.data(), end, found_major);
  if (error == std::errc() && dot != end) std::from_chars(dot + 1, end, found_minor);
  return found_major > major || (found_major == major && found_minor >= minor);
}

}  // namespace

lab::SweepScene sweep_scene(Session& session, RenderOptions options) {
  for (const char* name : {"quality", "translucency", "ray-traced"}) options.named.set(name, "");
  const sideray_scene_facts facts = session.facts(options);
  lab::SweepScene scene;
  scene.translucent_objects = facts.translucent_objects;
  scene.traceable_objects = facts.traceable_objects;
  scene.layered_objects = facts.layered_objects;
  if (facts.layered_objects > 0) scene.most_layers = std::min(facts.most_layers, most_layers);
  if (facts.translucent_objects > 0) scene.most_events = std::min(facts.most_surfaces, most_layers);
  scene.has_particles = facts.sprites > 0;
  scene.lights = facts.lit_lights;
  scene.swaying_objects = facts.swaying_objects;
  scene.swaying_copies = facts.swaying_copies;
  scene.has_cut_outs = facts.inexact_objects[SIDERAY_TARGET_MODEL] > 0;
  scene.has_gloss = facts.glossy_objects > 0;
  scene.has_environment = facts.has_environment != 0;
  scene.auto_ao = facts.auto_ao != 0 && options.named["ambient"] == "auto";
  scene.auto_bounce = facts.auto_bounce != 0 && options.named["ambient"] == "auto";
  scene.auto_reflections = facts.auto_reflections != 0 && options.named["reflections"] == "auto";
  scene.smallest_angle_deg = smallest_angle_deg(session.content(), session.camera());
  const sideray_device_info device = session.device(options);
  scene.by_rays = std::string_view(device.gl) == "none";
  scene.has_fragment_lists = !scene.by_rays && is_at_least(device.version, 4, 3);
  scene.is_sequence = options.frames.has_value();
  return scene;
}

}  // namespace sideray::cli
