#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "scenes/gltf.h"
#include "scenes/limits.h"

namespace sideray::scenes::gltf {
namespace {

double finite_number(const File& file, double value, size_t node) {
  if (!std::isfinite(value))
    refuse("cannot read {}: node {} has a transform that is not finite; correct it", file.path, node);
  return value;
}

glm::dvec3 vector_or(const File& file, const std::vector<double>& values, double fallback, size_t node) {
  if (values.size() != 3) return glm::dvec3(fallback);
  return {finite_number(file, values[0], node), finite_number(file, values[1], node),
          finite_number(file, values[2], node)};
}

glm::dmat4 parent_from_node(const File& file, size_t index) {
  const tinygltf::Node& node = file.model.nodes[index];
  if (node.matrix.size() == 16) {
    glm::dmat4 matrix(1.0);
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = finite_number(file, node.matrix[static_cast<size_t>(i)], index);
    return matrix;
  }
  const glm::dvec3 scale = vector_or(file, node.scale, 1.0, index);
  const glm::dvec3 translation = vector_or(file, node.translation, 0.0, index);
  glm::dquat rotation(1, 0, 0, 0);
  if (node.rotation.size() == 4) {
    const std::vector<double>& r = node.rotation;
    for (const double c : r) finite_number(file, c, index);
    rotation = glm::dquat(r[3], r[0], r[1], r[2]);
    const double length = glm::length(rotation);
    if (!(length > 1e-6)) refuse("cannot read {}: node {} has a rotation of length 0; correct it", file.path, index);
    // A unit quaternion stays as it is to the last bit.
    if (std::abs(length - 1.0) > 1e-12) rotation /= length;
  }
  glm::dmat4 matrix = glm::mat4_cast(rotation);
  for (int c = 0; c < 3; ++c) matrix[c] *= scale[c];
  matrix[3] = glm::dvec4(translation, 1.0);
  return matrix;
}

std::vector<int> root_nodes(const File& file, Content& content) {
  const tinygltf::Model& model = file.model;
  if (!model.scenes.empty()) {
    if (model.defaultScene < 0 && model.scenes.size() > 1) {
      content.defaulted.push_back(
          fmt::format("scene: the file has {} and names none; the first is shown", model.scenes.size()));
    }
    const int scene = std::max(model.defaultScene, 0);
    return model.scenes[checked_index(file, scene, model.scenes.size(), "scene", "the file")].nodes;
  }
  std::vector<bool> is_child(model.nodes.size(), false);
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    for (const int child : model.nodes[i].children) {
      is_child[checked_index(file, child, model.nodes.size(), "node", fmt::format("node {}", i))] = true;
    }
  }
  std::vector<int> roots;
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  }
  content.defaulted.emplace_back("scene: the file has none; all its nodes are shown");
  return roots;
}

std::string node_name(const File& file, size_t node) {
  const std::string& name = file.model.nodes[node].name;
  return name.empty() ? fmt::format("node{}", node) : name;
}

bool can_be_inverted(const glm::dmat4& m) {
  return std::abs(glm::determinant(glm::dmat3(m))) > limits::smallest_determinant;
}

void check_range(const File& file, const glm::dmat4& m, size_t node) {
  for (int i = 0; i < 16; ++i) {
    if (!(std::abs(m[i / 4][i % 4]) <= limits::coordinate)) {
      refuse("cannot read {}: node {} is placed beyond 1e15; move it closer", file.path, node_name(file, node));
    }
  }
}

class ObjectReader {
 public:
  ObjectReader(const File& file, Content& content) : file_(file), content_(content) {}

  void read(const PlacedNode& placed) {
    const tinygltf::Node& node = file_.model.nodes[placed.node];
    if (node.mesh < 0) return;
    const std::string name = node_name(file_, placed.node);
    const size_t mesh = checked_index(file_, node.mesh, file_.model.meshes.size(), "mesh", "node " + name);
    if (node.skin >= 0) {
      content_.warnings.push_back(
          fmt::format("node {}: its skin is not played yet; the shape is shown as stored", name));
    }
    const auto instances = instance_transforms(node, name);
    for (size_t p = 0; p < file_.model.meshes[mesh].primitives.size(); ++p) {
      const int content_mesh = primitive_mesh(mesh, p);
      if (content_mesh < 0) continue;
      const uint32_t material = material_of(file_.model.meshes[mesh].primitives[p].material, name);
      for (const glm::dmat4& node_from_instance : instances) {
        add(placed, name, static_cast<uint32_t>(content_mesh), material, placed.world_from_node * node_from_instance);
      }
    }
  }

  // KHR_materials_volume gives thickness in the mesh's space; materials hold world units. A node's mean scale decides.
  void scale_thickness() {
    std::map<std::pair<uint32_t, float>, uint32_t> scaled;
    std::map<uint32_t, float> first_scale;
    for (Object& object : content_.objects) {
      if (!(content_.materials[object.material].desc.thickness > 0.0f)) continue;
      const uint32_t source = object.material;
      const double* m = object.world_from_object;
      const glm::dmat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
      auto scale = static_cast<float>(std::cbrt(std::abs(glm::determinant(linear))));
      // Rounding of rigid transforms is no scale, and must not make a material for each object.
      if (std::abs(scale - 1.0f) < 1e-5f) scale = 1.0f;
      scale = std::round(scale * 65536.0f) > 0.0f && scale < 64.0f ? std::round(scale * 65536.0f) / 65536.0f : scale;
      const auto [found, is_new] = scaled.try_emplace({source, scale}, source);
      if (is_new && !first_scale.try_emplace(source, scale).second) {
        found->second = static_cast<uint32_t>(content_.materials.size());
        content_.materials.push_back(content_.materials[source]);
        content_.materials.back().desc.thickness *= scale;
      }
      object.material = found->second;
    }
    for (const auto& [material, scale] : first_scale) content_.materials[material].desc.thickness *= scale;
  }

 private:
  void add(const PlacedNode& placed, const std::string& name, uint32_t mesh, uint32_t material, const glm::dmat4& m) {
    check_range(file_, m, placed.node);
    if (!can_be_inverted(m)) {
      content_.warnings.push_back(fmt::format("node {}: its scale is 0; left out", name));
      return;
    }
    if (content_.objects.size() >= limits::objects) {
      refuse("cannot read {}: it places more than {} objects; use a smaller scene", file_.path, limits::objects);
    }
    Object object{.name = name, .mesh = mesh, .material = material};
    for (int c = 0; c < 4; ++c) {
      for (int r = 0; r < 3; ++r) object.world_from_object[3 * c + r] = m[c][r];
    }
    content_.objects.push_back(std::move(object));
  }

  // Index into Content::meshes, or -1 where there is nothing to draw. Shared by all nodes that use it.
  int primitive_mesh(size_t mesh, size_t primitive) {
    const auto [found, is_new] = meshes_.try_emplace({mesh, primitive}, -1);
    if (!is_new) return found->second;
    const tinygltf::Mesh& source = file_.model.meshes[mesh];
    std::string name = source.name.empty() ? fmt::format("mesh{}", mesh) : source.name;
    if (source.primitives.size() > 1) name += fmt::format(".{}", primitive);
    Mesh read = read_primitive(file_, source.primitives[primitive], name, content_);
    floats_ += read.positions.size() + read.normals.size() + read.tangents.size() + read.uv0.size() + read.uv1.size() +
               read.colors.size() + read.indices.size();
    if (floats_ > limits::mesh_numbers) {
      refuse("cannot read {}: its meshes need more than 4 GiB; use a smaller scene", file_.path);
    }
    if (read.indices.empty()) return -1;
    content_.meshes.push_back(std::move(read));
    return found->second = static_cast<int>(content_.meshes.size() - 1);
  }

  uint32_t material_of(int material, const std::string& name) {
    if (material >= 0) {
      return static_cast<uint32_t>(
          checked_index(file_, material, file_.model.materials.size(), "material", "node " + name));
    }
    if (default_material_ < 0) {
      default_material_ = static_cast<int>(content_.materials.size());
      Material material_without_name;
      material_without_name.name = "default";
      material_without_name.desc = sideray_material_defaults();
      // glTF 2.0, 3.9.6: what meshes without a material look like.
      material_without_name.desc.metallic = material_without_name.desc.roughness = 1.0f;
      content_.materials.push_back(std::move(material_without_name));
      content_.defaulted.emplace_back("material: some meshes have none; glTF's default material is shown");
    }
    return static_cast<uint32_t>(default_material_);
  }

  // Transforms of EXT_mesh_gpu_instancing, or the identity alone.
  std::vector<glm::dmat4> instance_transforms(const tinygltf::Node& node, const std::string& name) {
    const tinygltf::Value* e = extension(node.extensions, "EXT_mesh_gpu_instancing");
    if (e == nullptr || !e->Has("attributes")) return {glm::dmat4(1.0)};
    const tinygltf::Value& attributes = e->Get("attributes");
    size_t count = 0;
    const auto values = [&](const char* key, uint32_t components) -> std::vector<float> {
      if (!attributes.Has(key)) return {};
      const auto accessor = static_cast<int>(std::clamp(number(file_, attributes, key, -1.0), -1.0, 2e9));
      const std::string user = fmt::format("node {}, instance {}", name, key);
      std::vector<float> read = read_floats(file_, accessor, components, count, user);
      if (!std::all_of(read.begin(), read.end(), [](float x) { return std::isfinite(x); })) {
        refuse("cannot read {}: {} is not finite; correct it", file_.path, user);
      }
      count = read.size() / components;
      return read;
    };
    const std::vector<float> translations = values("TRANSLATION", 3), rotations = values("ROTATION", 4),
                             scales = values("SCALE", 3);
    std::vector<glm::dmat4> transforms;
    for (size_t i = 0; i < count; ++i) {
      glm::dmat4 m(1.0);
      if (!rotations.empty()) {
        const float* r = &rotations[4 * i];
        const glm::dquat q(double{r[3]}, double{r[0]}, double{r[1]}, double{r[2]});
        if (glm::length(q) > 1e-6) m = glm::mat4_cast(glm::normalize(q));
      }
      for (int c = 0; c < 3; ++c) {
        if (!scales.empty()) m[c] *= double{scales[3 * i + static_cast<size_t>(c)]};
        if (!translations.empty()) m[3][c] = double{translations[3 * i + static_cast<size_t>(c)]};
      }
      transforms.push_back(m);
    }
    return transforms;
  }

  const File& file_;
  Content& content_;
  std::map<std::pair<size_t, size_t>, int> meshes_;
  size_t floats_ = 0;
  int default_material_ = -1;
};

}  // namespace

std::vector<PlacedNode> place_nodes(const File& file, Content& content) {
  struct Pending {
    int node, depth;
    glm::dmat4 world_from_parent;
  };
  const size_t count = file.model.nodes.size();
  std::vector<Pending> pending;
  const auto push = [&](const std::vector<int>& nodes, int depth, const glm::dmat4& world_from_parent) {
    // Last in, first out: reversed, so that nodes come in the file's order.
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) pending.push_back({*node, depth, world_from_parent});
  };
  push(root_nodes(file, content), 0, glm::dmat4(1.0));
  std::vector<bool> seen(count, false);
  std::vector<PlacedNode> placed;
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const size_t node = checked_index(file, next.node, count, "node", "the scene");
    if (seen[node] || next.depth > limits::node_depth) {
      refuse("cannot read {}: node {} occurs twice in the scene or inside itself; export it again", file.path,
             node_name(file, node));
    }
    seen[node] = true;
    const glm::dmat4 world_from_node = next.world_from_parent * parent_from_node(file, node);
    placed.push_back({node, world_from_node});
    push(file.model.nodes[node].children, next.depth + 1, world_from_node);
  }
  return placed;
}

void read_objects(const File& file, std::span<const PlacedNode> nodes, Content& content) {
  ObjectReader reader(file, content);
  for (const PlacedNode& placed : nodes) reader.read(placed);
  reader.scale_thickness();
}

}  // namespace sideray::scenes::gltf
