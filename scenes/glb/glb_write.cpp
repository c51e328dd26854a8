#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "elementary/functions.h"
#include "scenes/base/files.h"
#include "scenes/base/limits.h"
#include "scenes/content/animation.h"
#include "scenes/content/content.h"
#include "scenes/glb/glb_instances.h"
#include "scenes/glb/glb_limits.h"
#include "scenes/images/images.h"

namespace sideray::scenes {
namespace {

using Json = nlohmann::json;
static_assert(std::endian::native == std::endian::little,
              "glTF buffers are little-endian; values are copied as they are");

constexpr int type_ushort = 5123, type_uint = 5125, type_float = 5126;
constexpr int gl_nearest = 9728, gl_linear = 9729, gl_linear_mipmap_linear = 9987;
constexpr int gl_repeat = 10497, gl_clamp_to_edge = 33071, gl_mirrored_repeat = 33648;

// Builds the JSON and the binary chunk. Numbers in the JSON are doubles, of which it keeps every bit.
class GlbWriter {
 public:
  GlbWriter(const Content& content, const std::string& path) : content_(content), path_(path) {}

  std::vector<uint8_t> bytes() {
    require_readable(path_, content_);
    root_["asset"] = {{"version", "2.0"}, {"generator", "Sideray"}};
    for (size_t i = 0; i < content_.materials.size(); ++i) root_["materials"].push_back(material(i));
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
    if (!extensions_.empty()) root_["extensionsUsed"] = extensions_;
    if (!binary_.empty()) root_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    JsonCount(path_).add(root_, 0, node_count);
    return container();
  }

 private:
  std::vector<uint8_t> container() {
    std::string json = root_.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary_.resize((binary_.size() + 3) / 4 * 4, 0);
    const size_t total = 12 + 8 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    if (total > limits::scene_file_bytes) {
      refuse("cannot write {}: it would have {} bytes, and {} are the most that is read; make the scene smaller", path_,
             total, limits::scene_file_bytes);
    }
    std::vector<uint8_t> bytes;
    bytes.reserve(total);
    const auto word = [&](size_t value) {
      for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift & 0xff));
    };
    word(0x46546c67), word(2), word(total);
    word(json.size()), word(0x4e4f534a);
    bytes.insert(bytes.end(), json.begin(), json.end());
    if (binary_.empty()) return bytes;
    word(binary_.size()), word(0x004e4942);
    bytes.insert(bytes.end(), binary_.begin(), binary_.end());
    return bytes;
  }

  size_t add_view(const void* data, size_t size) {
    binary_.resize((binary_.size() + 3) / 4 * 4, 0);
    const size_t offset = binary_.size();
    const auto* from = static_cast<const uint8_t*>(data);
    binary_.insert(binary_.end(), from, from + size);
    root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
    return root_["bufferViews"].size() - 1;
  }

  size_t add_accessor(const void* data, size_t count, size_t components, int component_type) {
    static constexpr const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const size_t view = add_view(data, count * components * (component_type == type_ushort ? 2 : 4));
    root_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", component_type},
                                  {"count", count},
                                  {"type", components == 16 ? "MAT4" : types[components]}});
    return root_["accessors"].size() - 1;
  }

  void add_attribute(Json& attributes, const char* name, const std::vector<float>& values, size_t components) {
    if (values.empty()) return;
    attributes[name] = add_accessor(values.data(), values.size() / components, components, type_float);
  }

  // Returns the attributes and indices of a mesh, which all its materials share.
  const Json& primitive(uint32_t index) {
    const auto [found, is_new] = primitives_.try_emplace(index);
    if (!is_new) return found->second;
    const Mesh& mesh = content_.meshes.at(index);
    Json attributes = Json::object();
    add_attribute(attributes, "POSITION", mesh.positions, 3);
    add_attribute(attributes, "NORMAL", mesh.normals, 3);
    add_attribute(attributes, "TANGENT", mesh.tangents, 4);
    add_attribute(attributes, "TEXCOORD_0", mesh.uv0, 2);
    add_attribute(attributes, "TEXCOORD_1", mesh.uv1, 2);
    add_attribute(attributes, "COLOR_0", mesh.colors, 4);
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
    found->second["indices"] = add_accessor(mesh.indices.data(), mesh.indices.size(), 1, type_uint);
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
    Json& attributes = node["extensions"][instancing_extension]["attributes"];
    add_attribute(attributes, "TRANSLATION", values.translations, 3);
    add_attribute(attributes, "ROTATION", values.rotations, 4);
    add_attribute(attributes, "SCALE", values.scales, 3);
    add_attribute(attributes, object_index_attribute, values.object_indices, 1);
    add_attribute(attributes, wind_phase_attribute, values.wind_phases, 1);
    for (size_t r = 0; r < 3; ++r) {
      const std::vector<uint16_t>& row = values.matrix_rows[r];
      if (!row.empty()) attributes[matrix_row_attributes[r]] = add_accessor(row.data(), group.size(), 16, type_ushort);
    }
    extensions_.insert(instancing_extension);
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
      particles["texture"] = texture(slot);
    }
    return node;
  }

  Json light_node(const Light& named) {
    const sideray_light& light = named.light;
    static constexpr const char* types[] = {"directional", "point", "spot"};
    // glTF splits a light into a colour up to 1 and an intensity. As doubles their product is exactly the light.
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
    extensions_.insert("KHR_lights_punctual");
    Json& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
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

  // Writes the animation, which moves cameras only: built-in scenes have no other. Camera nodes are roots, from
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
    const size_t input = add_accessor(channel.times.data(), channel.times.size(), 1, type_float);
    root_["accessors"][input]["min"] = {channel.times.front()};
    root_["accessors"][input]["max"] = {channel.times.back()};
    const size_t output =
        add_accessor(channel.values.data(), channel.values.size() / components, components, type_float);
    animation["samplers"].push_back({{"input", input},
                                     {"output", output},
                                     {"interpolation", interpolations[static_cast<int>(channel.interpolation)]}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1},
         {"target", {{"node", node}, {"path", paths[static_cast<int>(channel.property)]}}}});
  }

  size_t sampler(const sideray_texture_slot& slot) {
    static constexpr int wraps[] = {gl_repeat, gl_clamp_to_edge, gl_mirrored_repeat};
    static constexpr int minification[] = {gl_linear_mipmap_linear, gl_linear, gl_nearest};
    const auto key = std::make_tuple(slot.wrap_u, slot.wrap_v, slot.filter);
    const auto [found, is_new] = samplers_.try_emplace(key, samplers_.size());
    if (is_new) {
      root_["samplers"].push_back({{"wrapS", wraps[slot.wrap_u]},
                                   {"wrapT", wraps[slot.wrap_v]},
                                   {"magFilter", slot.filter == SIDERAY_NEAREST ? gl_nearest : gl_linear},
                                   {"minFilter", minification[slot.filter]}});
    }
    return found->second;
  }

  size_t image(uint32_t index) {
    const auto [found, is_new] = images_.try_emplace(index, images_.size());
    if (!is_new) return found->second;
    const Texture& texture = content_.textures.at(index);
    const std::vector<uint8_t> png = encode_png(texture.width, texture.height, 4, texture.rgba, texture.name);
    root_["images"].push_back(
        {{"name", texture.name}, {"mimeType", "image/png"}, {"bufferView", add_view(png.data(), png.size())}});
    return found->second;
  }

  size_t texture(const sideray_texture_slot& slot) {
    const std::pair<size_t, size_t> parts{image(slot.texture - 1), sampler(slot)};
    const auto [found, is_new] = textures_.try_emplace(parts, textures_.size());
    if (is_new) {
      root_["textures"].push_back(
          {{"name", content_.textures[slot.texture - 1].name}, {"source", parts.first}, {"sampler", parts.second}});
    }
    return found->second;
  }

  void set_texture(Json& parent, const char* key, const sideray_texture_slot& slot) {
    if (slot.texture == 0) return;
    Json info{{"index", texture(slot)}};
    if (slot.uv_set != 0) info["texCoord"] = slot.uv_set;
    set_transform(info, slot.texture_from_uv);
    parent[key] = std::move(info);
  }

  // Writes the map as scale, rotation and offset, which cannot express a shear: it is lost.
  void set_transform(Json& info, const float m[6]) {
    static constexpr float identity[6] = {1, 0, 0, 1, 0, 0};
    if (std::equal(identity, identity + 6, m)) return;
    const double sx = elementary::hypot(double{m[0]}, double{m[1]});
    const double determinant = double{m[0]} * double{m[3]} - double{m[1]} * double{m[2]};
    const double sy = std::copysign(elementary::hypot(double{m[2]}, double{m[3]}), determinant);
    extensions_.insert("KHR_texture_transform");
    Json& transform = info["extensions"]["KHR_texture_transform"];
    transform = {{"offset", {m[4], m[5]}}, {"scale", {sx, sy}}};
    if (m[1] != 0.0f || m[0] < 0.0f) transform["rotation"] = elementary::atan2(-double{m[1]}, double{m[0]});
  }

  // Returns the thickness in the mesh's space, as in glTF: loading multiplies it by the scale of the nodes that use it.
  float mesh_thickness(size_t index) const {
    const float thickness = content_.materials[index].desc.thickness;
    for (const Object& object : content_.objects) {
      if (object.material != index) continue;
      const double* m = object.world_from_object;
      const glm::dmat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
      const double scale = elementary::cbrt(std::abs(glm::determinant(linear)));
      return std::abs(scale - 1.0) < 1e-5 ? thickness : static_cast<float>(double{thickness} / scale);
    }
    return thickness;
  }

  Json& material_extension(Json& material, const char* name) {
    extensions_.insert(name);
    Json& extension = material["extensions"][name];
    if (extension.is_null()) extension = Json::object();
    return extension;
  }

  Json material(size_t index) {
    const Material& source = content_.materials[index];
    const sideray_material_desc& desc = source.desc;
    Json material{{"name", source.name}};
    Json& pbr = material["pbrMetallicRoughness"];
    pbr = {
        {"baseColorFactor", desc.base_color}, {"metallicFactor", desc.metallic}, {"roughnessFactor", desc.roughness}};
    set_texture(pbr, "baseColorTexture", desc.base_color_texture);
    set_texture(pbr, "metallicRoughnessTexture", desc.metallic_roughness_texture);
    set_texture(material, "normalTexture", desc.normal_texture);
    if (desc.normal_texture.texture != 0) material["normalTexture"]["scale"] = desc.normal_scale;
    set_texture(material, "occlusionTexture", desc.occlusion_texture);
    if (desc.occlusion_texture.texture != 0) material["occlusionTexture"]["strength"] = desc.occlusion_strength;
    set_texture(material, "emissiveTexture", desc.emissive_texture);
    if (desc.alpha_mode == SIDERAY_MASK) material["alphaMode"] = "MASK", material["alphaCutoff"] = desc.alpha_cutoff;
    if (desc.alpha_mode == SIDERAY_BLEND) material["alphaMode"] = "BLEND";
    if (desc.double_sided != 0) material["doubleSided"] = true;
    set_emission(material, desc);
    set_glass(material, desc, mesh_thickness(index));
    set_lobes(material, desc);
    set_extras(material, source);
    return material;
  }

  void set_emission(Json& material, const sideray_material_desc& desc) {
    const float strongest = *std::max_element(desc.emissive, desc.emissive + 3);
    if (strongest <= 0.0f) return;
    const float strength = std::max(strongest, 1.0f);
    material["emissiveFactor"] = {desc.emissive[0] / strength, desc.emissive[1] / strength,
                                  desc.emissive[2] / strength};
    if (strength > 1.0f) material_extension(material, "KHR_materials_emissive_strength")["emissiveStrength"] = strength;
  }

  void set_glass(Json& material, const sideray_material_desc& desc, float thickness) {
    if (desc.transmission > 0.0f || desc.transmission_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_transmission");
      e["transmissionFactor"] = desc.transmission;
      set_texture(e, "transmissionTexture", desc.transmission_texture);
    }
    if (desc.ior != 1.5f) material_extension(material, "KHR_materials_ior")["ior"] = desc.ior;
    if (desc.dispersion > 0.0f)
      material_extension(material, "KHR_materials_dispersion")["dispersion"] = desc.dispersion;
    const bool attenuates = std::isfinite(desc.attenuation_distance);
    if (thickness > 0.0f || attenuates || desc.thickness_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_volume");
      e["thicknessFactor"] = thickness;
      if (attenuates) e["attenuationDistance"] = desc.attenuation_distance;
      e["attenuationColor"] = desc.attenuation_color;
      set_texture(e, "thicknessTexture", desc.thickness_texture);
    }
  }

  // Writes each extension of which a factor or a texture is not the default.
  void set_lobes(Json& material, const sideray_material_desc& desc) {
    if (desc.unlit != 0) material_extension(material, "KHR_materials_unlit");
    if (desc.specular != 1.0f || !all(desc.specular_color, 1.0f) || desc.specular_texture.texture != 0 ||
        desc.specular_color_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_specular");
      e["specularFactor"] = desc.specular;
      e["specularColorFactor"] = desc.specular_color;
      set_texture(e, "specularTexture", desc.specular_texture);
      set_texture(e, "specularColorTexture", desc.specular_color_texture);
    }
    if (desc.clearcoat > 0.0f || desc.clearcoat_roughness > 0.0f || desc.clearcoat_texture.texture != 0 ||
        desc.clearcoat_roughness_texture.texture != 0 || desc.clearcoat_normal_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_clearcoat");
      e["clearcoatFactor"] = desc.clearcoat;
      e["clearcoatRoughnessFactor"] = desc.clearcoat_roughness;
      set_texture(e, "clearcoatTexture", desc.clearcoat_texture);
      set_texture(e, "clearcoatRoughnessTexture", desc.clearcoat_roughness_texture);
      set_texture(e, "clearcoatNormalTexture", desc.clearcoat_normal_texture);
      if (desc.clearcoat_normal_texture.texture != 0)
        e["clearcoatNormalTexture"]["scale"] = desc.clearcoat_normal_scale;
    }
    if (!all(desc.sheen_color, 0.0f) || desc.sheen_roughness > 0.0f || desc.sheen_color_texture.texture != 0 ||
        desc.sheen_roughness_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_sheen");
      e["sheenColorFactor"] = desc.sheen_color;
      e["sheenRoughnessFactor"] = desc.sheen_roughness;
      set_texture(e, "sheenColorTexture", desc.sheen_color_texture);
      set_texture(e, "sheenRoughnessTexture", desc.sheen_roughness_texture);
    }
    if (desc.diffuse_transmission > 0.0f || !all(desc.diffuse_transmission_color, 1.0f) ||
        desc.diffuse_transmission_texture.texture != 0 || desc.diffuse_transmission_color_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_diffuse_transmission");
      e["diffuseTransmissionFactor"] = desc.diffuse_transmission;
      e["diffuseTransmissionColorFactor"] = desc.diffuse_transmission_color;
      set_texture(e, "diffuseTransmissionTexture", desc.diffuse_transmission_texture);
      set_texture(e, "diffuseTransmissionColorTexture", desc.diffuse_transmission_color_texture);
    }
    if (desc.anisotropy > 0.0f || desc.anisotropy_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_anisotropy");
      e["anisotropyStrength"] = desc.anisotropy;
      e["anisotropyRotation"] = desc.anisotropy_rotation;
      set_texture(e, "anisotropyTexture", desc.anisotropy_texture);
    }
    if (desc.iridescence > 0.0f || desc.iridescence_texture.texture != 0 ||
        desc.iridescence_thickness_texture.texture != 0) {
      Json& e = material_extension(material, "KHR_materials_iridescence");
      e["iridescenceFactor"] = desc.iridescence;
      e["iridescenceIor"] = desc.iridescence_ior;
      e["iridescenceThicknessMinimum"] = desc.iridescence_thickness_min;
      e["iridescenceThicknessMaximum"] = desc.iridescence_thickness_max;
      set_texture(e, "iridescenceTexture", desc.iridescence_texture);
      set_texture(e, "iridescenceThicknessTexture", desc.iridescence_thickness_texture);
    }
  }

  static bool all(const float color[3], float value) {
    return std::all_of(color, color + 3, [value](float c) { return c == value; });
  }

  static void set_extras(Json& material, const Material& source) {
    static constexpr const char* blends[] = {"alpha", "premultiplied", "additive", "multiply"};
    Json extras = Json::object();
    if (source.ray_traced != RayTraced::by_default) extras["rayTraced"] = source.ray_traced == RayTraced::yes;
    if (source.desc.blend_mode != SIDERAY_BLEND_ALPHA) extras["blend"] = blends[source.desc.blend_mode];
    if (source.inexact_shadow) extras["inexactShadow"] = true;
    if (source.desc.distortion > 0.0f) extras["distortion"] = source.desc.distortion;
    if (!extras.empty()) material["extras"]["sideray"] = std::move(extras);
  }

  const Content& content_;
  const std::string& path_;
  Json root_ = Json::object();
  std::vector<uint8_t> binary_;
  std::set<std::string> extensions_;
  std::map<uint32_t, Json> primitives_;
  std::map<std::pair<uint32_t, uint32_t>, size_t> meshes_;
  std::map<std::tuple<sideray_wrap, sideray_wrap, sideray_filter>, size_t> samplers_;
  std::map<uint32_t, size_t> images_;
  std::map<std::pair<size_t, size_t>, size_t> textures_;
};

}  // namespace

void write_glb(const std::string& path, const Content& content) {
  write_file(path, GlbWriter(content, path).bytes());
}

}  // namespace sideray::scenes
