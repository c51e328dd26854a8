#include "lab/stress/stress_scene.h"

#include "lab/metrics/metrics.h"
#include "scenes/base/files.h"

namespace sideray::lab {

Pane pane_across(double depth) {
  const double half = 4.0 * depth;
  return {{{{-half, -half, -depth}, {half, -half, -depth}, {half, half, -depth}, {-half, half, -depth}}}};
}

sideray_mesh add_triangles(Scene& scene, std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = static_cast<uint32_t>(positions.size());
  mesh.positions.data = &positions[0].x;
  mesh.index_count = static_cast<uint32_t>(indices.size());
  mesh.indices = indices.data();
  return scene.add_mesh(mesh);
}

void set_light_from_above(Scene& scene) {
  const sideray_light sun = sideray_light_defaults();
  scene.set_lights({&sun, 1});
}

sideray_instance add_quad(Scene& scene, const Pane& pane, const sideray_material_desc& material, uint32_t surface_id,
                          sideray_wind wind) {
  std::vector<glm::vec3> positions;
  for (const glm::dvec3& corner : pane.corners) positions.emplace_back(corner);
  const std::array<uint32_t, 6> indices{0, 1, 2, 0, 2, 3};
  sideray_instance_desc instance{};
  instance.mesh = add_triangles(scene, positions, indices);
  instance.material = scene.add_material(material);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) instance.world_from_object[3 * column + row] = pane.world_from_pane[column][row];
  instance.surface_id = surface_id;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  instance.wind = wind;
  return scene.add_instances({&instance, 1}).front();
}

Scene scene_of_panes(const std::vector<Pane>& panes) {
  Scene scene = Scene::create().value();
  for (size_t i = 0; i < panes.size(); ++i) {
    sideray_material_desc glass = sideray_material_defaults();
    glass.alpha_mode = SIDERAY_BLEND;
    glass.unlit = 1;
    glass.double_sided = 1;
    // Adjacent panes differ in every channel.
    for (size_t c = 0; c < 3; ++c) glass.base_color[c] = (i + c) % 2 == 0 ? 0.9f : 0.1f;
    glass.base_color[3] = 0.4f;
    add_quad(scene, panes[i], glass, static_cast<uint32_t>(i + 1));
  }
  scene.commit();
  return scene;
}

sideray_camera camera_at(const glm::dmat4& world_from_camera, double fov_deg, double near) {
  sideray_camera camera{};
  camera.size = sizeof(camera);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) camera.world_from_camera[3 * column + row] = world_from_camera[column][row];
  camera.yfov = static_cast<float>(glm::radians(fov_deg));
  camera.z_near = static_cast<float>(near);
  return camera;
}

RenderOptions picture_options(const StressStage& stage, sideray_shadows shadows, sideray_translucency translucency) {
  RenderOptions options;
  options.picture.ambient = SIDERAY_AMBIENT_OFF;
  options.picture.reflections = 0;
  options.picture.width = stage.width;
  options.picture.height = stage.height;
  options.picture.repeats = 0;
  options.shadows->method = shadows;
  options.translucency->method = translucency;
  options.translucency->ray_reuse = 0.0f;
  options.picture.denoise = 0;
  return options;
}

RenderOptions sequence_options(const StressStage& stage, sideray_ambient ambient) {
  RenderOptions options;
  options.picture.width = stage.width;
  options.picture.height = stage.height;
  options.picture.repeats = 0;
  options.picture.ambient = ambient;
  options.picture.reflections = 1;
  options.picture.taa = 1;
  return options;
}

void set_frame(RenderOptions& options, uint32_t frame, bool continues) {
  options.picture.continues = continues;
  options.picture.seed = frame + 1;
}

const void* Planes::find(const std::string& name) const {
  for (size_t i = 0; i < picture_.channel_count(); ++i)
    if (const sideray_channel channel = picture_.channel(i); channel.name == name) return channel.values;
  scenes::refuse("stress: the picture has no channel {}; this is a defect, please report it", name);
}
const float* Planes::floats(const std::string& name) const {
  return static_cast<const float*>(find(name));
}
const uint32_t* Planes::whole(const std::string& name) const {
  return static_cast<const uint32_t*>(find(name));
}

scenes::Image image_of(const Picture& picture) {
  const Planes planes(picture);
  scenes::Image image{picture.width(), picture.height(), {}, true};
  for (const char* name : {"R", "G", "B"}) {
    const float* values = planes.floats(name);
    image.planes.push_back({name, scenes::Plane::Type::half, {values, values + planes.pixels()}, {}});
  }
  return image;
}

double flip(const scenes::Image& test, const scenes::Image& reference) {
  return compare(test, reference).metrics.flip.value();
}

FailureMap map_of(const StressStage& stage) {
  return {stage.width, stage.height, std::vector<uint8_t>(size_t{stage.width} * stage.height)};
}

std::vector<double> swept(const StressStage& stage, std::vector<double> values, std::vector<double> quick_values) {
  return stage.quick ? quick_values : values;
}

}  // namespace sideray::lab
