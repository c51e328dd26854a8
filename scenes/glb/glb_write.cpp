#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "scenes/base/files.h"
#include "scenes/content/animation.h"
#include "scenes/content/content.h"
#include "scenes/glb/glb_document.h"
#include "scenes/glb/glb_instances.h"
#include "scenes/glb/glb_limits.h"
#include "scenes/glb/glb_materials.h"

namespace sideray::scenes {
namespace {

using Json = GlbDocument::Json;

// Writes a scene into a GLB file.
class GlbWriter {
 public:
  GlbWriter(const Content& content, const std::string& path) : content_(content), path_(path) {}

  std::vector<uint8_t> bytes() {
    require_readable(path_, content_);
    root_["asset"] = {{"version", "2.0"}, {"generator", "Sideray"}};
    for (size_t i = 0; i < content_.materials.size(); ++i) root_["materials"].push_back(materials_.material(i));
    Json nodes = Json::array();
    JsonCount node_values(path_);
    for (const ObjectGroup& group : group_objects(content_)) {
      nodes.push_back(group.size() == 1 ? object_node(content_.objects[group[0]]) : instanced_node(group));
      node_values.add(nodes.back(), 2, nodes.size());
    }
    const size_t first_camera = nodes.size() + content_.lights.size();
    for (const Light& light : content_.lights) nodes.push_back(light_node(light));
    for (const Camera& camera : content_.cameras) nodes.push_back(camera_node(camera));
    if (content_.rig) set_animation(*content_.rig, first_camera, nodes);
    for (const Emitter& emitter : content_.emitters) nodes.push_back(emitter_node(emitter));
    Json scene = Json::object();
    for (size_t i = 0; i < nodes.size(); ++i) scene["nodes"].push_back(i);
    const size_t node_count = nodes.size();
    if (!nodes.empty()) root_["nodes"] = std::move(nodes);
    root_["scenes"] = Json::array({scene});
    root_["scene"] = 0;
    document_.finish();
    JsonCount(path_).add(root_, 0, node_count);
    return document_.bytes(path_);
  }

 private:
  // Returns the attributes and indices of a mesh; primitives with different materials share them.
  const Json& primitive(uint32_t index) {
    const auto [found, is_new] = primitives_.try_emplace(index);
    if (!is_new) return found->second;
    const Mesh& mesh = content_.meshes.at(index);
    Json attributes = Json::object();
    document_.add_attribute(attributes, "POSITION", mesh.positions, 3);
    document_.add_attribute(attributes, "NORMAL", mesh.normals, 3);
    document_.add_attribute(attributes, "TANGENT", mesh.tangents, 4);
    document_.add_attribute(attributes, "TEXCOORD_0", mesh.uv0, 2);
    document_.add_attribute(attributes, "TEXCOORD_1", mesh.uv1, 2);
    document_.add_attribute(attributes, "COLOR_0", mesh.colors, 4);
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
      const glm::vec3 p(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]);
      low = glm::min(low, p), high = glm::max(high, p);
    }
    Json& accessor = root_["accessors"][attributes["POSITION"].get<size_t>()];
    accessor["min"] = {low.x, low.y, low.z};
    accessor["max"] = {high.x, high.y, high.z};
    found->second["attributes"] = std::move(attributes);
    if (mesh.topology != SIDERAY_TRIANGLES) found->second["mode"] = mesh.topology == SIDERAY_LINES ? 1 : 0;
    found->second["indices"] =
        document_.add_accessor(mesh.indices.data(), mesh.indices.size(), 1, GlbDocument::type_uint);
    return found->second;
  }

  size_t mesh_with_material(uint32_t mesh, uint32_t material) {
    const auto [found, is_new] = meshes_.try_emplace({mesh, material}, 0);
    if (!is_new) return found->second;
    Json with_material = primitive(mesh);
    with_material["material"] = material;
    root_["meshes"].push_back(
        {{"name", content_.meshes[mesh].name}, {"primitives", Json::array({std::move(with_material)})}});
    return found->second = root_["meshes"].size() - 1;
  }

  static Json matrix(const double* columns_of_three) {
    Json values = Json::array();
    for (int c = 0; c < 4; ++c) {
      for (int r = 0; r < 3; ++r) values.push_back(columns_of_three[3 * c + r]);
      values.push_back(c == 3 ? 1.0 : 0.0);
    }
    return values;
  }

  static void set_matrix(Json& node, const double* columns_of_three) {
    static constexpr double identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    if (!std::equal(identity, identity + 12, columns_of_three)) node["matrix"] = matrix(columns_of_three);
  }

  Json object_node(const Object& object) {
    Json node{{"name", object.name}, {"mesh", mesh_with_material(object.mesh, object.material)}};
    set_matrix(node, object.world_from_object);
    if (object.wind != 0) node["extras"]["sideray"]["wind"] = wind(object);
    return node;
  }

  Json instanced_node(const ObjectGroup& group) {
    const Object& first = content_.objects[group[0]];
    const InstanceAttributes values = instance_attributes(content_, group);
    Json node{{"name", first.name}, {"mesh", mesh_with_material(first.mesh, first.material)}};
    Json& attributes = document_.extension(node, instancing_extension)["attributes"];
    document_.add_attribute(attributes, "TRANSLATION", values.translations, 3);
    document_.add_attribute(attributes, "ROTATION", values.rotations, 4);
    document_.add_attribute(attributes, "SCALE", values.scales, 3);
    document_.add_attribute(attributes, object_index_attribute, values.object_indices, 1);
    document_.add_attribute(attributes, wind_phase_attribute, values.wind_phases, 1);
    for (size_t r = 0; r < 3; ++r) {
      const std::vector<uint16_t>& row = values.matrix_rows[r];
      if (row.empty()) continue;
      attributes[matrix_row_attributes[r]] =
          document_.add_accessor(row.data(), group.size(), 16, GlbDocument::type_ushort);
    }
    if (first.wind != 0) {
      node["extras"]["sideray"]["wind"] = wind(first);
      node["extras"]["sideray"]["wind"].erase("phase");
    }
    return node;
  }

  Json wind(const Object& object) const {
    const sideray_wind_desc& d = content_.winds.at(object.wind - 1);
    return {{"amplitude", d.amplitude},
            {"frequency", d.frequency},
            {"height", d.height},
            {"direction", d.direction},
            {"branch_amplitude", d.branch_amplitude},
            {"branch_frequency", d.branch_frequency},
            {"leaf_amplitude", d.leaf_amplitude},
            {"leaf_frequency", d.leaf_frequency},
            {"wavelength", d.wavelength},
            {"phase", object.wind_phase}};
  }

  Json emitter_node(const Emitter& emitter) {
    Json node{{"name", emitter.node}};
    set_matrix(node, emitter.world_from_node);
    Json& particles = node["extras"]["sideray"]["particles"] = Json::parse(emitter.json);
    particles.erase("texture");
    if (emitter.texture != 0) {
      sideray_texture_slot slot{};
      slot.texture = emitter.texture;
      slot.wrap_u = slot.wrap_v = SIDERAY_CLAMP;
      particles["texture"] = materials_.texture(slot);
    }
    return node;
  }

  Json light_node(const Light& named) {
    const sideray_light& light = named.light;
    static constexpr const char* types[] = {"directional", "point", "spot"};
    // glTF splits a light into a colour up to 1 and a strength; both are written as doubles whose product is exactly
    // the light.
    const float strength = *std::max_element(light.intensity, light.intensity + 3);
    const double divisor = strength > 0.0f ? double{strength} : 1.0;
    Json json{{"name", named.name}, {"type", types[light.type]}, {"intensity", strength}};
    json["color"] = {double{light.intensity[0]} / divisor, double{light.intensity[1]} / divisor,
                     double{light.intensity[2]} / divisor};
    if (light.range > 0.0f) json["range"] = light.range;
    if (light.type == SIDERAY_LIGHT_SPOT) {
      json["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
    }
    Json extras = Json::object();
    if (light.type == SIDERAY_LIGHT_DIRECTIONAL) extras["angular_diameter_deg"] = light.angular_diameter_deg;
    if (light.radius > 0.0f) extras["radius_m"] = light.radius;
    if (!extras.empty()) json["extras"]["sideray"] = std::move(extras);
    Json& lights = document_.extension(root_, "KHR_lights_punctual")["lights"];
    lights.push_back(std::move(json));
    Json node{{"name", named.name}};
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    double placement[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, light.position[0], light.position[1], light.position[2]};
    if (light.type != SIDERAY_LIGHT_POINT) {
      const double origin[3] = {0, 0, 0};
      const double along[3] = {double{light.direction[0]}, double{light.direction[1]}, double{light.direction[2]}};
      std::copy_n(look_at(origin, along, 45.0f).world_from_camera, 9, placement);
    }
    set_matrix(node, placement);
    return node;
  }

  Json camera_node(const Camera& named) {
    const sideray_camera& camera = named.camera;
    Json json{{"name", named.name}};
    if (camera.orthographic != 0) {
      const float aspect = named.aspect > 0.0f ? named.aspect : 1.0f;
      json["type"] = "orthographic";
      json["orthographic"] = {{"xmag", double{camera.half_height} * double{aspect}},
                              {"ymag", camera.half_height},
                              {"znear", camera.z_near},
                              {"zfar", camera.z_far}};
    } else {
      json["type"] = "perspective";
      json["perspective"] = {{"yfov", camera.yfov}, {"znear", camera.z_near}};
      if (camera.z_far > 0.0f) json["perspective"]["zfar"] = camera.z_far;
      if (named.aspect > 0.0f) json["perspective"]["aspectRatio"] = named.aspect;
    }
    root_["cameras"].push_back(std::move(json));
    Json node{{"name", named.name}, {"camera", root_["cameras"].size() - 1}};
    set_matrix(node, camera.world_from_camera);
    return node;
  }

  // Writes the cameras that move, because built-in scenes animate nothing else. Their nodes are roots, from
  // `first_camera` on.
  void set_animation(const Rig& rig, size_t first_camera, Json& nodes) {
    Json animation{{"name", content_.animations.at(0).name}};
    for (const Attached& moving : rig.cameras) {
      const size_t node = first_camera + moving.index;
      const Placement& rest = rig.nodes[moving.node].rest;
      nodes[node].erase("matrix");
      nodes[node]["translation"] = {rest.translation.x, rest.translation.y, rest.translation.z};
      nodes[node]["rotation"] = {rest.rotation.x, rest.rotation.y, rest.rotation.z, rest.rotation.w};
      for (const Channel& channel : rig.channels)
        if (channel.node == moving.node) add_channel(channel, node, animation);
    }
    if (animation.contains("channels")) root_["animations"].push_back(std::move(animation));
  }

  void add_channel(const Channel& channel, size_t node, Json& animation) {
    static constexpr const char* paths[] = {"translation", "rotation", "scale"};
    static constexpr const char* interpolations[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    const size_t components = channel.property == Property::rotation ? 4 : 3;
    const size_t input = document_.add_accessor(channel.times.data(), channel.times.size(), 1, GlbDocument::type_float);
    root_["accessors"][input]["min"] = {channel.times.front()};
    root_["accessors"][input]["max"] = {channel.times.back()};
    const size_t output = document_.add_accessor(channel.values.data(), channel.values.size() / components, components,
                                                 GlbDocument::type_float);
    animation["samplers"].push_back({{"input", input},
                                     {"output", output},
                                     {"interpolation", interpolations[static_cast<int>(channel.interpolation)]}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1},
         {"target", {{"node", node}, {"path", paths[static_cast<int>(channel.property)]}}}});
  }

  const Content& content_;
  const std::string& path_;
  GlbDocument document_;
  Json& root_ = document_.root();
  GlbMaterials materials_{content_, document_};
  std::map<uint32_t, Json> primitives_;
  std::map<std::pair<uint32_t, uint32_t>, size_t> meshes_;
};

}  // namespace

void write_glb(const std::string& path, const Content& content) {
  write_file(path, GlbWriter(content, path).bytes());
}

}  // namespace sideray::scenes
