#include "viewer/drawing/inspect.h"

#include <cmath>

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

Surface surface_of(const sideray_hit& hit, const scenes::Content& content) {
  Surface surface{hit.distance, hit.surface_id, hit.primitive, "", "", ""};
  const size_t index = static_cast<size_t>(hit.instance) - 1;  // objects are the scene's instances, in their order
  if (index >= content.objects.size()) return surface;
  const scenes::Object& object = content.objects[index];
  const scenes::Material& material = content.materials[object.material];
  surface.object = object.name;
  surface.material = material.name;
  surface.kind = kind_of(material.desc);
  return surface;
}

}  // namespace

Inspection inspect(Tracer& tracer, const View& view, Pixel pixel) {
  const sideray_ray ray = ray_through(view, pixel);
  Inspection inspection{view.number, pixel, {}};
  const sideray_hit opaque = tracer.trace(SIDERAY_RAYS_OPAQUE, std::span(&ray, 1)).front();
  for (const sideray_hit& hit : tracer.trace(SIDERAY_RAYS_TRANSLUCENT, std::span(&ray, 1), most_layers))
    if (std::isfinite(hit.distance) && hit.distance < opaque.distance)
      inspection.surfaces.push_back(surface_of(hit, view.scene->content()));
  if (std::isfinite(opaque.distance)) inspection.surfaces.push_back(surface_of(opaque, view.scene->content()));
  return inspection;
}

}  // namespace sideray::viewer
