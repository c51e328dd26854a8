#include "viewer/drawing/inspect.h"

#include <fmt/format.h>

#include <cmath>

#include "viewer/drawing/modes.h"
#include "viewer/scene/navigation.h"

namespace sideray::viewer {
namespace {

constexpr uint32_t most_layers = 16;

sideray_ray ray_through(const View& view, Pixel pixel) {
  const double width = view.width, height = view.height;
  const glm::dvec3 direction =
      direction_through(view.camera, (pixel.x + 0.5) / width, (pixel.y + 0.5) / height, width / height);
  const glm::dvec3 eye = eye_of(view.camera);
  const glm::vec3 unit(glm::normalize(direction));
  return {{eye.x, eye.y, eye.z}, {unit.x, unit.y, unit.z}, view.camera.z_near, 1e30f};
}

const char* kind_of(const sideray_material_desc& material) {
  if (!sideray_material_is_translucent(&material)) return material.alpha_mode == SIDERAY_MASK ? "opaque with holes" : "opaque";
  if (material.transmission <= 0) return "blended";
  return material.thickness > 0 ? "volume, bends light" : "thin, transmits light";
}

Surface surface_of(const sideray_hit& hit, SceneFile& scene) {
  const scenes::Content& content = scene.content();
  Surface surface{hit.distance, hit.surface_id, hit.primitive, "", "", ""};
  const size_t index = static_cast<size_t>(hit.instance) - 1;  // objects are the scene's instances, in their order
  if (index >= content.objects.size()) return surface;
  const scenes::Object& object = content.objects[index];
  const scenes::Material& material = content.materials[object.material];
  surface.object = object.name;
  surface.material = material.name;
  surface.kind = kind_of(material.desc);
  if (sideray_material_is_translucent(&material.desc) && !scene.is_traced(index)) surface.kind += ", not in --ray-traced";
  return surface;
}

// Returns a value of a channel of SIDERAY_AOV_ANSWERS.
std::string words_of(uint32_t answer) {
  if (answer == 1) return "none, as without rays";
  if (answer == 2) return "traced";
  if (answer == 3) return "earlier, still right";
  return fmt::format("earlier, {} {} ago", answer - 3, answer == 4 ? "change" : "changes");
}

}  // namespace

Inspection inspect(Tracer& tracer, const View& view, Pixel pixel) {
  const sideray_ray ray = ray_through(view, pixel);
  Inspection inspection{view.number, pixel, {}};
  const sideray_hit opaque = tracer.trace(SIDERAY_RAYS_OPAQUE, std::span(&ray, 1)).front();
  for (const sideray_hit& hit : tracer.trace(SIDERAY_RAYS_TRANSLUCENT, std::span(&ray, 1), most_layers))
    if (std::isfinite(hit.distance) && hit.distance < opaque.distance)
      inspection.surfaces.push_back(surface_of(hit, *view.scene));
  if (std::isfinite(opaque.distance)) inspection.surfaces.push_back(surface_of(opaque, *view.scene));
  return inspection;
}

std::string answers_at(const Frame& frame, const View& view, Pixel pixel) {
  constexpr std::pair<const char*, const char*> channels[] = {{"answer.lights", "light"},
                                                              {"answer.sky", "sky"},
                                                              {"answer.reflections", "reflection"},
                                                              {"answer.layers", "glass"}};
  if (frame.way == Way::raster) return "no rays";
  const std::string positions = fmt::format("{} position{}", frame.positions, frame.positions == 1 ? "" : "s");
  if (frame.way == Way::reference) return "traced, " + positions;
  const size_t x = size_t{pixel.x} * frame.width / std::max(view.width, 1u);
  const size_t y = size_t{pixel.y} * frame.height / std::max(view.height, 1u);
  std::string line;
  bool has_channels = false;
  for (const auto& [channel, name] : channels) {
    const uint32_t* answers = frame.picture ? numbers_of(*frame.picture, channel) : nullptr;
    if (!answers || x >= frame.width || y >= frame.height) continue;
    has_channels = true;
    if (const uint32_t answer = answers[y * frame.width + x]; answer > 0)
      line += fmt::format("{}{}: {}", line.empty() ? "" : ", ", name, words_of(answer));
  }
  if (has_channels) return line.empty() ? "asks for no rays" : line;
  const std::string size = frame.is_preview ? fmt::format(" at {}x{}", frame.width, frame.height) : "";
  return fmt::format("all traced{}, {}", size, positions);
}

}  // namespace sideray::viewer
