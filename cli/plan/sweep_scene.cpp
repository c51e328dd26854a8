#include "cli/plan/sweep_scene.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include "scenes/content/placement.h"

namespace sideray::cli {
namespace {

using scenes::Content;
using scenes::Material;
using scenes::Object;

constexpr size_t most_layers = 8;
// Up to which the renderer mirrors by rays (docs/cli.md, --reflections).
constexpr float most_mirrored_roughness = 0.5f;

bool is_translucent(const Material& material) {
  return material.desc.alpha_mode == SIDERAY_BLEND || material.desc.transmission > 0.0f;
}

bool is_cut_out(const Material& material) {
  const sideray_material_desc& m = material.desc;
  return m.double_sided && (m.alpha_mode == SIDERAY_MASK || m.diffuse_transmission > 0.0f);
}

bool may_mirror(const Material& material) {
  const sideray_material_desc& m = material.desc;
  return !m.unlit && (m.roughness <= most_mirrored_roughness || m.metallic_roughness_texture.texture != 0);
}

bool is_lit(const scenes::Light& light) {
  const float* color = light.light.intensity;
  return color[0] != 0.0f || color[1] != 0.0f || color[2] != 0.0f;
}

// Under which the sphere around an object's box appears; 180 from within.
double angle_deg(const Content& content, const Object& object, const sideray_camera& camera) {
  const scenes::Bounds bounds = scenes::bounds_of(content, object);
  if (bounds.empty()) return 180;
  const double* m = camera.world_from_camera;
  const double distance = glm::distance(0.5 * (bounds.minimum + bounds.maximum), glm::dvec3(m[9], m[10], m[11]));
  const double radius = 0.5 * glm::distance(bounds.minimum, bounds.maximum);
  return radius >= distance ? 180 : 2 * std::asin(radius / distance) * 180 / std::numbers::pi;
}

void describe_objects(const Session& session, lab::SweepScene& scene) {
  const Content& content = session.content();
  std::map<uint32_t, size_t> swaying;  // of each mesh
  for (const Object& object : content.objects) {
    const Material& material = content.materials[object.material];
    // Nothing is too far away for a view without perspective.
    if (!session.camera().orthographic)
      scene.smallest_angle_deg = std::min(scene.smallest_angle_deg, angle_deg(content, object, session.camera()));
    if (is_translucent(material)) {
      ++scene.translucent_objects;
      continue;
    }
    scene.has_cut_outs |= is_cut_out(material);
    scene.has_gloss |= may_mirror(material);
    if (object.wind == 0) continue;
    ++scene.swaying_objects;
    scene.swaying_copies = std::max(scene.swaying_copies, ++swaying[object.mesh]);
  }
  scene.has_particles = std::any_of(content.emitters.begin(), content.emitters.end(),
                                    [](const scenes::Emitter& emitter) { return !emitter.sprites.empty(); });
}

size_t count_traced(Session& session, RenderOptions options, const std::string& selection) {
  options.ray_traced = selection;
  const std::vector<bool> traced = session.ray_traced(options);
  return static_cast<size_t>(std::count(traced.begin(), traced.end(), true));
}

// How many layers the plan keeps of as many as there can be: no more than a ray meets.
size_t count_layers(Session& session, RenderOptions options, const std::string& selection) {
  options.ray_traced = selection;
  options.options.layers = most_layers;
  return sideray_plan_layers(session.plan(options).plan.get());
}

bool is_at_least(const std::string& version, int major, int minor) {
  int found_major = 0, found_minor = 0;
  const char* end = version.data() + version.size();
  const auto [dot, error] = std::from_chars(version.data(), end, found_major);
  if (error == std::errc() && dot != end) std::from_chars(dot + 1, end, found_minor);
  return found_major > major || (found_major == major && found_minor >= minor);
}

}  // namespace

lab::SweepScene sweep_scene(Session& session, const RenderOptions& options) {
  lab::SweepScene scene;
  describe_objects(session, scene);
  scene.traceable_objects = count_traced(session, options, "all");
  scene.layered_objects = count_traced(session, options, "auto");
  if (scene.layered_objects > 0) scene.most_layers = count_layers(session, options, "auto");
  // What cannot have layers is met by rays all the same: then as many as may be.
  if (scene.translucent_objects > 0 && scene.traceable_objects == scene.translucent_objects)
    scene.most_events = count_layers(session, options, "all");
  const std::vector<scenes::Light>& lights = session.content().lights;
  scene.lights = static_cast<size_t>(std::count_if(lights.begin(), lights.end(), is_lit));
  scene.has_environment = options.environment != "none" && options.environment_scale > 0;
  scene.has_fragment_lists = is_at_least(session.device(options).version, 4, 3);
  scene.is_sequence = options.frames.has_value();
  return scene;
}

}  // namespace sideray::cli
