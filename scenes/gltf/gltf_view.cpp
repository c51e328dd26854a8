#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <utility>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"
#include "scenes/gltf/gltf_pointer.h"

// Reads the cameras and lights of nodes.
namespace sideray::scenes::gltf {
namespace {

glm::dmat4 rigid(const File& file, const PlacedNode& placed) {
  const glm::dmat4 result = without_scale(placed.world_from_node);
  for (int i = 0; i < 16; ++i) {
    if (!(std::abs(result[i / 4][i % 4]) <= limits::coordinate)) {
      refuse("cannot read {}: node {} holds a camera or light and cannot be inverted; correct its transform", file.path,
             placed.node);
    }
  }
  return result;
}

void check_positive(const File& file, double value, const char* key, const std::string& camera) {
  if (!(value > 0.0 && value < 1e15)) {
    refuse("cannot read {}: {} of camera {} is {}; give a number above 0", file.path, key, camera, value);
  }
}

void read_perspective(const File& file, const tinygltf::PerspectiveCamera& source, Camera& camera) {
  check_positive(file, source.yfov, "yfov", camera.name);
  check_positive(file, source.znear, "znear", camera.name);
  if (!(source.yfov < glm::pi<double>())) {
    refuse("cannot read {}: yfov of camera {} is {}; give less than pi", file.path, camera.name, source.yfov);
  }
  const bool infinite = source.zfar == 0.0;
  if (!infinite && !(source.zfar > source.znear && source.zfar < 1e15)) {
    refuse("cannot read {}: zfar of camera {} is {}; give more than znear", file.path, camera.name, source.zfar);
  }
  camera.camera.yfov = static_cast<float>(source.yfov);
  camera.camera.z_near = static_cast<float>(source.znear);
  camera.camera.z_far = static_cast<float>(source.zfar);
  if (source.aspectRatio > 0.0) camera.aspect = static_cast<float>(source.aspectRatio);
}

void read_orthographic(const File& file, const tinygltf::OrthographicCamera& source, Camera& camera) {
  // Negative sizes mirror the picture in no viewer; the validator warns of them.
  const double half_width = std::abs(source.xmag), half_height = std::abs(source.ymag);
  check_positive(file, half_width, "xmag", camera.name);
  check_positive(file, half_height, "ymag", camera.name);
  check_positive(file, source.zfar, "zfar", camera.name);
  if (!(source.znear >= 0.0 && source.znear < source.zfar)) {
    refuse("cannot read {}: znear of camera {} is {}; give 0 or more, below zfar", file.path, camera.name,
           source.znear);
  }
  camera.camera.orthographic = 1;
  camera.camera.half_height = static_cast<float>(half_height);
  // glTF allows znear 0 here, where a small share of the range differs invisibly.
  camera.camera.z_near = static_cast<float>(source.znear > 0.0 ? source.znear : 1e-6 * source.zfar);
  camera.camera.z_far = static_cast<float>(source.zfar);
  camera.aspect = static_cast<float>(half_width / half_height);
}

bool is_light(const std::string& type) {
  return type == "directional" || type == "point" || type == "spot";
}

struct LightReader {
  const File& file;
  const std::string& name;
  Warnings& warnings;

  double value(double number, const char* key, double minimum, double maximum) const {
    if (number < minimum && number >= minimum - 0.01) {
      warnings.push_back(fmt::format("light {}: {} is {}; {} is taken", name, key, number, minimum));
      number = minimum;
    }
    if (!(number >= minimum && number <= maximum)) {
      refuse("cannot read {}: {} of light {} is {}; give {} to {}", file.path, key, name, number, minimum, maximum);
    }
    return number;
  }
  float single(double number, const char* key, double minimum, double maximum) const {
    return static_cast<float>(value(number, key, minimum, maximum));
  }

  void read_cones(const tinygltf::SpotLight& spot, sideray_light& light) const {
    light.inner_cone = single(spot.innerConeAngle, "innerConeAngle", 0.0, 1.5709);
    light.outer_cone = std::min(single(spot.outerConeAngle, "outerConeAngle", 0.0, 1.5709), glm::half_pi<float>());
    if (light.inner_cone < light.outer_cone) return;
    // Blender writes two equal angles for a cone with a hard edge.
    if (!(light.outer_cone > 0.0f))
      refuse("cannot read {}: outerConeAngle of light {} is 0; give more", file.path, name);
    warnings.push_back(
        fmt::format("light {}: innerConeAngle is not below outerConeAngle; the cone has a hard edge", name));
    light.inner_cone = inner_cone_of(spot.innerConeAngle, light.outer_cone);
  }

  sideray_light read(const tinygltf::Light& source, const glm::dmat4& world_from_node) const {
    sideray_light light{};
    light.size = sizeof(light);
    if (source.type == "directional")
      light.type = SIDERAY_LIGHT_DIRECTIONAL;
    else if (source.type == "point")
      light.type = SIDERAY_LIGHT_POINT;
    else
      light.type = SIDERAY_LIGHT_SPOT;
    if (!source.color.empty() && source.color.size() != 3) {
      refuse("cannot read {}: color of light {} is not three numbers; correct it", file.path, name);
    }
    const double intensity = value(source.intensity, "intensity", 0.0, 1e9);
    for (int c = 0; c < 3; ++c) {
      const double color = source.color.empty() ? 1.0 : source.color[static_cast<size_t>(c)];
      light.intensity[c] = static_cast<float>(value(color, "color", 0.0, 1e6) * intensity);
    }
    place_light(light, world_from_node);
    if (light.type != SIDERAY_LIGHT_DIRECTIONAL) light.range = single(source.range, "range", 0.0, 1e15);
    if (light.type == SIDERAY_LIGHT_DIRECTIONAL) light.angular_diameter_deg = 0.53f;
    if (light.type == SIDERAY_LIGHT_SPOT) read_cones(source.spot, light);
    if (const tinygltf::Value* extras = sideray_extras(source.extras)) {
      for (const std::string& key : extras->Keys())
        if (key != "angular_diameter_deg" && key != "radius_m")
          warnings.push_back(fmt::format("light {}: extras.sideray.{} is unknown and left out", name, key));
      light.angular_diameter_deg =
          single(number(file, *extras, "angular_diameter_deg", double{light.angular_diameter_deg}),
                "angular_diameter_deg", 0.0, 180.0);
      light.radius = single(number(file, *extras, "radius_m", 0.0), "radius_m", 0.0, 1e6);
    }
    return light;
  }
};

// Makes names unique, since shadow.NAME identifies a light (cli.md). Lights without a name, and all that share one, are
// renamed to "lightI". A light that already has such a name is renamed too.
void make_names_unique(std::vector<Light>& lights) {
  std::map<std::string, std::vector<size_t>> bearers;
  for (size_t i = 0; i < lights.size(); ++i) bearers[lights[i].name].push_back(i);
  std::vector<std::string> clashes;
  for (const auto& [name, of] : bearers)
    if (name.empty() || of.size() > 1) clashes.push_back(name);
  while (!clashes.empty()) {
    const std::string name = std::move(clashes.back());
    clashes.pop_back();
    std::vector<size_t> kept;
    for (const size_t i : std::exchange(bearers[name], {})) {
      std::string own = fmt::format("light{}", i);
      if (own == name) {
        kept.push_back(i);
        continue;
      }
      std::vector<size_t>& others = bearers[own];
      others.push_back(i);
      if (others.size() == 2) clashes.push_back(own);
      lights[i].name = std::move(own);
    }
    auto& left = bearers[name];
    left.insert(left.end(), kept.begin(), kept.end());
  }
}

Light default_sun() {
  Light sun{.name = "sun", .light = {}};
  sun.light.size = sizeof(sun.light);
  sun.light.type = SIDERAY_LIGHT_DIRECTIONAL;
  const float direction[3] = {-0.4f, -0.8f, -0.45f};
  std::copy_n(direction, 3, sun.light.direction);
  std::fill_n(sun.light.intensity, 3, 3.0f);
  sun.light.angular_diameter_deg = 0.53f;
  return sun;
}

Camera read_camera(const File& file, const tinygltf::Camera& source, const PlacedNode& placed, std::string name) {
  Camera camera;
  camera.name = std::move(name);
  if (file.broken_cameras.contains(static_cast<size_t>(file.model.nodes[placed.node].camera)))
    refuse("cannot read {}: camera {} has an unknown type or lacks numbers; correct it", file.path, camera.name);
  camera.camera = {};
  camera.camera.size = sizeof(camera.camera);
  const glm::dmat4 m = rigid(file, placed);
  for (int i = 0; i < 12; ++i) camera.camera.world_from_camera[i] = m[i / 3][i % 3];
  if (source.type == "perspective")
    read_perspective(file, source.perspective, camera);
  else
    read_orthographic(file, source.orthographic, camera);
  return camera;
}

// Returns whether lights and cameras of the node can be placed: a scale of 0 leaves them no direction.
bool can_be_placed(const PlacedNode& placed) {
  const glm::dmat4 m = without_scale(placed.world_from_node);
  for (int i = 0; i < 12; ++i)
    if (!std::isfinite(m[i / 4][i % 4])) return false;
  return true;
}

Attached attached(size_t index, const PlacedNode& placed, std::span<const PlacedNode> nodes) {
  return {.index = static_cast<uint32_t>(index),
          .node = static_cast<uint32_t>(&placed - nodes.data()),
          .node_from_it = glm::dmat4(1.0)};
}

}  // namespace

std::vector<ReadThing> read_cameras(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content) {
  std::vector<ReadThing> read;
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = file.model.nodes[placed.node];
    if (node.camera < 0) continue;
    const auto& cameras = file.model.cameras;
    const tinygltf::Camera& source =
        cameras[checked_index(file, node.camera, cameras.size(), "camera", fmt::format("node {}", placed.node))];
    std::string name = !node.name.empty() ? node.name : source.name;
    if (name.empty()) name = fmt::format("camera{}", content.cameras.size());
    Camera camera;
    try {
      camera = read_camera(file, source, placed, name);
    } catch (const Error& error) {
      // Like other viewers, we show the scene without the camera.
      content.warnings.push_back(fmt::format("{}; the camera is left out", reason_of(error, file)));
      continue;
    }
    const Attached on_node = attached(content.cameras.size(), placed, nodes);
    if (placed.moves) rig.cameras.push_back(on_node);
    read.push_back({static_cast<size_t>(node.camera), on_node.node, on_node.index});
    content.cameras.push_back(std::move(camera));
  }
  return read;
}

std::vector<ReadThing> read_lights(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content) {
  std::vector<ReadThing> read;
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = file.model.nodes[placed.node];
    const tinygltf::Value* e = extension(node.extensions, "KHR_lights_punctual");
    if (e == nullptr || placed.is_hidden) continue;
    const auto index = static_cast<int>(std::clamp(number(file, *e, "light", -1.0), -1.0, 2e9));
    const auto& lights = file.model.lights;
    const tinygltf::Light& source =
        lights[checked_index(file, index, lights.size(), "light", fmt::format("node {}", placed.node))];
    const std::string name = node.name.empty() ? fmt::format("of node {}", placed.node) : node.name;
    if (!can_be_placed(placed) || !is_light(source.type)) {
      content.warnings.push_back(fmt::format(
          "light {}: {}; left out", name,
          is_light(source.type) ? "a scale of its node is 0" : fmt::format("its type \"{}\" is unknown", source.type)));
      continue;
    }
    const LightReader reader{file, name, content.warnings};
    const Attached on_node = attached(content.lights.size(), placed, nodes);
    if (placed.moves) rig.lights.push_back(on_node);
    read.push_back({static_cast<size_t>(index), on_node.node, on_node.index});
    content.lights.push_back({node.name, reader.read(source, rigid(file, placed))});
  }
  make_names_unique(content.lights);
  if (content.lights.size() > limits::lights) {
    content.warnings.push_back(
        fmt::format("lights: the first {} of {} are used", limits::lights, content.lights.size()));
    content.lights.resize(limits::lights);
    std::erase_if(rig.lights, [](const Attached& a) { return a.index >= limits::lights; });
    std::erase_if(read, [](const ReadThing& light) { return light.of_content >= limits::lights; });
  }
  return read;
}

void add_default_light(Content& content) {
  content.lights.push_back(default_sun());
  content.defaulted.emplace_back(
      "light: the file has none; a directional light \"sun\" of irradiance 3.0 along (-0.4, -0.8, -0.45)");
}

Content load(const std::string& path, const LoadOptions& options) {
  Budget budget(path, options.limits);
  File file = read(path, budget);
  Content content;
  content.name = path;
  content.hash = file.hash;
  content.warnings = std::move(file.warnings);
  content.extensions = file.model.extensionsUsed;
  apply_variant(file, options.variant, content);
  const auto rig = std::make_shared<Rig>();
  std::vector<PlacedNode> nodes = place_nodes(file, *rig, content);
  const std::vector<AnimatedValue> values = read_animations(file, nodes, options.animation, *rig, content);
  const std::vector<glm::dmat4> world = rig->world_from_nodes(options.time_s);
  for (size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].world_from_node = world[i];
    nodes[i].moves = rig->nodes[i].moves;
    nodes[i].is_hidden = rig->is_always_hidden(static_cast<uint32_t>(i));
  }
  const std::map<uint32_t, Scattering> scattering = read_materials(file, nodes, content);
  warn_of_unused_images(file, content);
  const std::vector<uint32_t> places = read_objects(file, nodes, *rig, content);
  ReadThings read;
  read.cameras = read_cameras(file, nodes, *rig, content);
  read.lights = read_lights(file, nodes, *rig, content);
  if (content.lights.empty() && options.default_light) add_default_light(content);
  read_node_extras(file, nodes, content);
  order_objects(places, *rig, content);
  read.materials = scale_thickness(varying_thickness(values), content);
  show_scattering(scattering, read.materials, content);
  animate_values(file, values, read, *rig, content);
  if (content.cameras.empty()) content.defaulted.emplace_back("camera: the file has none; the whole scene is framed");
  content.rig = rig;
  pose(content, options.time_s);
  // Without animations skins are applied once, and the rig is not needed.
  if (rig->channels.empty() && values.empty()) content.rig.reset();
  return content;
}

}  // namespace sideray::scenes::gltf
