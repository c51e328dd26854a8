#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <tuple>

#include "elementary/functions.h"
#include "scenes/base/limits.h"
#include "scenes/glb/glb_instances.h"
#include "scenes/gltf/gltf.h"

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

Placement placement_of(const File& file, size_t index, Content& content) {
  const tinygltf::Node& node = file.model.nodes[index];
  Placement placement;
  placement.scale = vector_or(file, node.scale, 1.0, index);
  placement.translation = vector_or(file, node.translation, 0.0, index);
  if (node.rotation.size() != 4) return placement;
  const std::vector<double>& r = node.rotation;
  for (const double c : r) finite_number(file, c, index);
  placement.rotation = glm::dquat(r[3], r[0], r[1], r[2]);
  const double length = glm::length(placement.rotation);
  if (!(length > 1e-6)) {
    content.warnings.push_back(fmt::format("node {}: its rotation has length 0; it is not turned", index));
    placement.rotation = glm::dquat(1.0, 0.0, 0.0, 0.0);
    return placement;
  }
  // A unit quaternion keeps all its bits.
  if (std::abs(length - 1.0) > 1e-12) placement.rotation /= length;
  return placement;
}

// KHR_node_visibility.
bool is_hidden(const File& file, size_t index) {
  const tinygltf::Value* e = extension(file.model.nodes[index].extensions, "KHR_node_visibility");
  if (e == nullptr || !e->Has("visible")) return false;
  const tinygltf::Value& visible = e->Get("visible");
  if (!visible.IsBool())
    refuse("cannot read {}: visible of node {} is not true or false; correct it", file.path, index);
  return !visible.Get<bool>();
}

RigNode rig_node(const File& file, size_t index, int parent, Content& content) {
  RigNode node;
  node.parent = parent;
  node.is_hidden = is_hidden(file, index);
  const std::vector<double>& matrix = file.model.nodes[index].matrix;
  if (matrix.size() == 16) {
    for (int i = 0; i < 16; ++i)
      node.parent_from_node[i / 4][i % 4] = finite_number(file, matrix[static_cast<size_t>(i)], index);
    return node;
  }
  node.rest = placement_of(file, index, content);
  node.parent_from_node = matrix_of(node.rest);
  return node;
}

// Returns for each node whether it is the child of another.
std::vector<bool> children_of(const File& file) {
  const auto& nodes = file.model.nodes;
  std::vector<bool> is_child(nodes.size(), false);
  for (const tinygltf::Node& node : nodes)
    for (const int child : node.children)
      if (static_cast<size_t>(child) < nodes.size()) is_child[static_cast<size_t>(child)] = true;
  return is_child;
}

// Sorts the scene's nodes. Some exporters also list nodes that are children of others: those come last, after their
// parents have placed them.
std::vector<int> parents_first(const File& file, std::vector<int> roots) {
  const std::vector<bool> is_child = children_of(file);
  std::stable_partition(roots.begin(), roots.end(), [&](int node) {
    return !(static_cast<size_t>(node) < is_child.size() && is_child[static_cast<size_t>(node)]);
  });
  return roots;
}

std::vector<int> root_nodes(const File& file, Content& content) {
  const tinygltf::Model& model = file.model;
  if (!model.scenes.empty()) {
    if (model.defaultScene < 0 && model.scenes.size() > 1) {
      content.defaulted.push_back(
          fmt::format("scene: the file has {} and names none; the first is shown", model.scenes.size()));
    }
    const int scene = std::max(model.defaultScene, 0);
    const size_t shown = checked_index(file, scene, model.scenes.size(), "scene", "the file");
    return parents_first(file, model.scenes[shown].nodes);
  }
  for (size_t i = 0; i < model.nodes.size(); ++i)
    for (const int child : model.nodes[i].children)
      checked_index(file, child, model.nodes.size(), "node", fmt::format("node {}", i));
  const std::vector<bool> is_child = children_of(file);
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

void check_range(const File& file, const glm::dmat4& m, size_t node) {
  for (int i = 0; i < 16; ++i) {
    if (!(std::abs(m[i / 4][i % 4]) <= limits::coordinate)) {
      refuse("cannot read {}: node {} is placed beyond 1e15; move it closer", file.path, node_name(file, node));
    }
  }
}

class ObjectReader {
 public:
  ObjectReader(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content)
      : file_(file), nodes_(nodes), rig_(rig), content_(content), skins_(file, nodes, rig) {}

  void read(const PlacedNode& placed) {
    const tinygltf::Node& node = file_.model.nodes[placed.node];
    if (node.mesh < 0 || placed.is_hidden) return;
    const std::string name = node_name(file_, placed.node);
    const size_t mesh = checked_index(file_, node.mesh, file_.model.meshes.size(), "mesh", "node " + name);
    const auto& primitives = file_.model.meshes[mesh].primitives;
    const Weights weights{rest_weights(file_, node, name, content_), static_cast<uint32_t>(&placed - nodes_.data())};
    if (node.skin >= 0) return read_skinned(node, mesh, name, weights);
    const Instances instances = read_instances(file_, node, name, content_);
    for (size_t p = 0; p < primitives.size(); ++p) {
      const int content_mesh = primitive_mesh(mesh, p, weights);
      if (content_mesh < 0) continue;
      const uint32_t material = material_of(primitives[p].material, name);
      for (size_t i = 0; i < instances.node_from_instance.size(); ++i) {
        Object object{.name = name, .mesh = static_cast<uint32_t>(content_mesh), .material = material};
        if (!instances.wind_phases.empty()) object.wind_phase = instances.wind_phases[i];
        const uint32_t place = instances.object_indices.empty() ? any_place : instances.object_indices[i];
        add(placed, std::move(object), instances.node_from_instance[i], place);
      }
    }
  }

  std::vector<uint32_t> take_places() { return std::move(places_); }

 private:
  // Holds the weights of a node's morph targets at rest, and the node of the rig whose channels change them.
  struct Weights {
    std::vector<double> rest;
    uint32_t node;
  };

  // Reads a skinned mesh. The joints alone place its vertices, in world space; the node's transform is ignored (glTF
  // 2.0, 3.7.3.3).
  void read_skinned(const tinygltf::Node& node, size_t mesh, const std::string& name, const Weights& weights) {
    const uint32_t skin = skins_.skin(node.skin, "node " + name);
    if (extension(node.extensions, instancing_extension) != nullptr) {
      content_.warnings.push_back(fmt::format("node {}: what has a skin is not instanced; shown once", name));
    }
    const auto& primitives = file_.model.meshes[mesh].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      const size_t morphed = rig_.morphed.size();
      const int content_mesh = shaped_mesh(mesh, p, weights);
      if (content_mesh < 0) continue;
      const auto index = static_cast<uint32_t>(content_mesh);
      const uint32_t material = material_of(primitives[p].material, name);
      if (skins_.read(primitives[p], skin, index, content_.meshes[index], content_)) {
        count_skinned();
        if (morphed < rig_.morphed.size()) {
          rig_.morphed.back().is_skinned = true;
          rig_.skinned.back().morphed = static_cast<int>(morphed);
        }
      }
      Object object;
      object.name = name, object.mesh = index, object.material = material;
      set_transform(object, glm::dmat4(1.0));
      if (rig_.nodes[weights.node].blinks)
        rig_.objects.push_back({.index = static_cast<uint32_t>(content_.objects.size()),
                                .node = weights.node,
                                .node_from_it = glm::dmat4(1.0),
                                .is_in_world = true});
      push(std::move(object), any_place);
    }
  }

  void add(const PlacedNode& placed, Object object, const glm::dmat4& node_from_object, uint32_t place) {
    const glm::dmat4 m = placed.world_from_node * node_from_object;
    check_range(file_, m, placed.node);
    if (!placed.moves && !can_be_inverted(m)) {
      content_.warnings.push_back(
          fmt::format("node {}: its transform leaves no volume (a scale is 0); left out", object.name));
      return;
    }
    set_transform(object, m);
    if (placed.moves) {
      rig_.objects.push_back({.index = static_cast<uint32_t>(content_.objects.size()),
                              .node = static_cast<uint32_t>(&placed - nodes_.data()),
                              .node_from_it = node_from_object});
    }
    push(std::move(object), place);
  }

  void push(Object object, uint32_t place) {
    if (content_.objects.size() % 1024 == 0) {
      file_.budget.take(1024 * (sizeof(Object) + sizeof(uint32_t) + most_name_bytes(object)), "its objects");
      file_.budget.check_time("its objects");
    }
    if (content_.objects.size() >= limits::objects) {
      refuse("cannot read {}: it places more than {} objects; use a smaller scene", file_.path, limits::objects);
    }
    content_.objects.push_back(std::move(object));
    places_.push_back(place);
  }

  // Returns the index in Content::meshes, or -1 where there is nothing to draw. Nodes with the same weights share a
  // mesh; a node with animated weights has its own.
  int primitive_mesh(size_t mesh, size_t primitive, const Weights& weights) {
    if (!weights.rest.empty() && rig_.nodes[weights.node].is_morphing) return shaped_mesh(mesh, primitive, weights);
    const auto [found, is_new] = meshes_.try_emplace({mesh, primitive, weights.rest}, -1);
    if (is_new) found->second = shaped_mesh(mesh, primitive, weights);
    return found->second;
  }

  // Reads the mesh at these weights, which are permanent where nothing changes them.
  int shaped_mesh(size_t mesh, size_t primitive, const Weights& weights) {
    const int index = read_mesh(mesh, primitive);
    if (index < 0 || weights.rest.empty()) return index;
    Mesh& shaped = content_.meshes[static_cast<size_t>(index)];
    const tinygltf::Primitive& source = file_.model.meshes[mesh].primitives[primitive];
    if (source.targets.size() != weights.rest.size())
      refuse("cannot read {}: mesh {} has {} morph targets where another primitive has {}; export it again",
             file_.path, shaped.name, source.targets.size(), weights.rest.size());
    const auto [targets, is_new] = targets_.try_emplace({mesh, primitive});
    if (is_new) {
      // Counts before reading: many targets can name the same bytes.
      for (const auto& target : source.targets) count(target.size() * shaped.positions.size());
      targets->second = read_targets(file_, source, shaped, content_);
    }
    MorphedMesh morphed{.mesh = static_cast<uint32_t>(index),
                        .node = weights.node,
                        .base = shaped,
                        .targets = targets->second,
                        .weights = weights.rest};
    morphed.base.indices.clear();
    blend(morphed.base, *morphed.targets, morphed.weights, shaped);
    if (!rig_.nodes[weights.node].is_morphing) return index;
    count(numbers_of(morphed.base));
    file_.budget.take(numbers_of(morphed.base) * sizeof(float), "its morphed meshes");
    rig_.morphed.push_back(std::move(morphed));
    return index;
  }

  static size_t numbers_of(const Mesh& m) {
    return m.positions.size() + m.normals.size() + m.tangents.size() + m.uv0.size() + m.uv1.size() + m.colors.size() +
           m.indices.size();
  }

  int read_mesh(size_t mesh, size_t primitive) {
    const tinygltf::Mesh& source = file_.model.meshes[mesh];
    std::string name = source.name.empty() ? fmt::format("mesh{}", mesh) : source.name;
    if (source.primitives.size() > 1) name += fmt::format(".{}", primitive);
    Mesh read = read_primitive(file_, source.primitives[primitive], name, content_);
    count(numbers_of(read));
    if (read.indices.empty()) return -1;
    content_.meshes.push_back(std::move(read));
    return static_cast<int>(content_.meshes.size() - 1);
  }

  // Returns the memory of a name, 0 for one that the string itself can hold.
  static size_t most_name_bytes(const Object& object) {
    return object.name.size() < sizeof(std::string) / 2 ? 0 : object.name.size();
  }

  void count_skinned() {
    const SkinnedMesh& skinned = rig_.skinned.back();
    const size_t numbers =
        skinned.positions.size() + skinned.normals.size() + skinned.tangents.size() + 2 * skinned.weights.size();
    count(numbers);
    file_.budget.take(numbers * sizeof(float), "its skinned meshes");
  }

  void count(size_t numbers) {
    numbers_ += numbers;
    if (numbers_ > limits::mesh_numbers) {
      refuse("cannot read {}: its meshes need more than 4 GiB; use a smaller scene", file_.path);
    }
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
      // The default material of glTF 2.0, 3.9.6.
      material_without_name.desc.metallic = material_without_name.desc.roughness = 1.0f;
      content_.materials.push_back(std::move(material_without_name));
      content_.defaulted.emplace_back("material: some meshes have none; glTF's default material is shown");
    }
    return static_cast<uint32_t>(default_material_);
  }

  const File& file_;
  std::span<const PlacedNode> nodes_;
  Rig& rig_;
  Content& content_;
  SkinReader skins_;
  std::map<std::tuple<size_t, size_t, std::vector<double>>, int> meshes_;
  std::map<std::pair<size_t, size_t>, std::shared_ptr<const MorphTargets>> targets_;  // by mesh and primitive
  std::vector<uint32_t> places_;  // for each object
  size_t numbers_ = 0;
  int default_material_ = -1;
};

}  // namespace

std::vector<PlacedNode> place_nodes(const File& file, Rig& rig, Content& content) {
  struct Pending {
    int node, depth, parent;
  };
  const size_t count = file.model.nodes.size();
  std::vector<Pending> pending;
  const auto push = [&](const std::vector<int>& nodes, int depth, int parent) {
    // Pushed in reverse, so that nodes are popped in the file's order.
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) pending.push_back({*node, depth, parent});
  };
  push(root_nodes(file, content), 0, -1);
  std::vector<bool> seen(count, false);
  std::vector<PlacedNode> placed;
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const size_t node = checked_index(file, next.node, count, "node", "the scene");
    if (seen[node] && next.parent < 0) {
      content.warnings.push_back(
          fmt::format("node {}: the scene lists it, and shows it already; shown once", node_name(file, node)));
      continue;
    }
    if (next.depth > limits::node_depth && !seen[node])
      refuse("cannot read {}: node {} lies deeper than {} nodes; put it and its children higher", file.path,
             node_name(file, node), limits::node_depth);
    if (seen[node]) {
      refuse("cannot read {}: node {} occurs twice in the scene or inside itself; export it again", file.path,
             node_name(file, node));
    }
    seen[node] = true;
    if (placed.size() % 1024 == 0) {
      file.budget.take(1024 * (sizeof(PlacedNode) + sizeof(RigNode)), "its nodes");
      file.budget.check_time("its nodes");
    }
    const RigNode& stored = rig.nodes.emplace_back(rig_node(file, node, next.parent, content));
    const glm::dmat4 world_from_parent =
        next.parent < 0 ? glm::dmat4(1.0) : placed[static_cast<size_t>(next.parent)].world_from_node;
    placed.push_back({.node = node, .world_from_node = world_from_parent * stored.parent_from_node});
    push(file.model.nodes[node].children, next.depth + 1, static_cast<int>(placed.size() - 1));
  }
  return placed;
}

std::vector<uint32_t> read_objects(const File& file, std::span<PlacedNode> nodes, Rig& rig, Content& content) {
  ObjectReader reader(file, nodes, rig, content);
  for (PlacedNode& placed : nodes) {
    placed.first_object = static_cast<uint32_t>(content.objects.size());
    reader.read(placed);
    placed.object_count = static_cast<uint32_t>(content.objects.size()) - placed.first_object;
  }
  return reader.take_places();
}

// Scales by the mean scale of each object.
std::vector<ScaledMaterial> scale_thickness(const std::set<uint32_t>& thickness_varies, Content& content) {
  std::map<std::pair<uint32_t, float>, uint32_t> scaled;
  std::map<uint32_t, float> first_scale;
  for (Object& object : content.objects) {
    const uint32_t source = object.material;
    if (!(content.materials[source].desc.thickness > 0.0f) && !thickness_varies.contains(source)) continue;
    const double* m = object.world_from_object;
    const glm::dmat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
    auto scale = static_cast<float>(elementary::cbrt(std::abs(glm::determinant(linear))));
    // The rounding of rigid transforms must not make another material for each object.
    if (std::abs(scale - 1.0f) < 1e-5f) scale = 1.0f;
    scale = std::round(scale * 65536.0f) > 0.0f && scale < 64.0f ? std::round(scale * 65536.0f) / 65536.0f : scale;
    const auto [found, is_new] = scaled.try_emplace({source, scale}, source);
    if (is_new && !first_scale.try_emplace(source, scale).second) {
      found->second = static_cast<uint32_t>(content.materials.size());
      content.materials.push_back(content.materials[source]);
      content.materials.back().desc.thickness *= scale;
    }
    object.material = found->second;
  }
  std::vector<ScaledMaterial> result;
  for (const auto& [material, scale] : first_scale) {
    content.materials[material].desc.thickness *= scale;
    result.push_back({material, material, scale});
  }
  for (const auto& [from, material] : scaled)
    if (material != from.first) result.push_back({from.first, material, from.second});
  return result;
}

}  // namespace sideray::scenes::gltf
