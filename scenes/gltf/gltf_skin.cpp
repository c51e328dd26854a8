#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

// Reads skins, and the joints and weights of vertices.
namespace sideray::scenes::gltf {
namespace {

constexpr uint32_t most_sets = 2;  // of four influences each

size_t attribute_sets(const tinygltf::Primitive& primitive) {
  size_t sets = 0;
  while (primitive.attributes.contains(fmt::format("JOINTS_{}", sets)) &&
         primitive.attributes.contains(fmt::format("WEIGHTS_{}", sets))) {
    ++sets;
  }
  return sets;
}

// Divides weights by their sum. A vertex without weights follows its first joint.
void normalize(float* weights, uint32_t count) {
  double sum = 0.0;
  for (uint32_t i = 0; i < count; ++i) {
    if (!(weights[i] > 0.0f && weights[i] < 1e15f)) weights[i] = 0.0f;
    sum += double{weights[i]};
  }
  if (!(sum > 0.0)) weights[0] = 1.0f, sum = 1.0;
  for (uint32_t i = 0; i < count; ++i) weights[i] = static_cast<float>(double{weights[i]} / sum);
}

}  // namespace

SkinReader::SkinReader(const File& file, std::span<const PlacedNode> nodes, Rig& rig)
    : file_(file), rig_(rig), rig_node_(file.model.nodes.size(), -1) {
  for (size_t i = 0; i < nodes.size(); ++i) rig_node_[nodes[i].node] = static_cast<int>(i);
}

uint32_t SkinReader::skin(int index, const std::string& user) {
  const auto& skins = file_.model.skins;
  const tinygltf::Skin& source = skins[checked_index(file_, index, skins.size(), "skin", user)];
  const auto [found, is_new] = skins_.try_emplace(index, static_cast<uint32_t>(rig_.skins.size()));
  if (!is_new) return found->second;
  const std::string what = fmt::format("skin {}", index);
  if (source.joints.empty() || source.joints.size() > limits::joints) {
    refuse("cannot read {}: {} has {} joints, not 1 to {}; export it again", file_.path, what, source.joints.size(),
           limits::joints);
  }
  Skin skin;
  for (const int joint : source.joints) {
    const int node = rig_node_[checked_index(file_, joint, rig_node_.size(), "node", what)];
    if (node < 0) {
      refuse("cannot read {}: {} has the joint {}, which is not in the scene; export it again", file_.path, what,
             joint);
    }
    skin.joints.push_back(static_cast<uint32_t>(node));
  }
  skin.joint_from_mesh.resize(skin.joints.size(), glm::dmat4(1.0));
  if (source.inverseBindMatrices >= 0) read_inverse_bind_matrices(source.inverseBindMatrices, what, skin);
  rig_.skins.push_back(std::move(skin));
  return found->second;
}

void SkinReader::read_inverse_bind_matrices(int accessor, const std::string& what, Skin& skin) {
  const std::string user = what + ", inverseBindMatrices";
  const size_t count = accessor_count(file_, accessor, user);
  if (count < skin.joints.size() || count > limits::joints) {
    refuse("cannot read {}: {} are {} for {} joints; export it again", file_.path, user, count, skin.joints.size());
  }
  const std::vector<float> values = read_floats(file_, accessor, 16, 0, user);
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    for (int i = 0; i < 16; ++i) {
      const double value = double{values[16 * j + static_cast<size_t>(i)]};
      if (!(std::abs(value) <= limits::coordinate)) {
        refuse("cannot read {}: {} have a number beyond 1e15; correct it", file_.path, user);
      }
      skin.joint_from_mesh[j][i / 4][i % 4] = value;
    }
  }
}

bool SkinReader::read(const tinygltf::Primitive& primitive, uint32_t skin, uint32_t content_mesh, const Mesh& mesh,
                      Content& content) {
  const size_t stored = attribute_sets(primitive);
  const auto sets = static_cast<uint32_t>(std::min<size_t>(stored, most_sets));
  if (sets == 0) {
    content.warnings.push_back(
        fmt::format("mesh {}: it has a skin and no joints; the shape is shown as stored", mesh.name));
    return false;
  }
  if (stored > most_sets) {
    content.warnings.push_back(fmt::format("mesh {}: the first {} joints a vertex are used", mesh.name, 4 * most_sets));
  }
  SkinnedMesh skinned{.mesh = content_mesh,
                      .skin = skin,
                      .positions = mesh.positions,
                      .normals = mesh.normals,
                      .tangents = mesh.tangents,
                      .influences = 4 * sets,
                      .joints = {},
                      .weights = {}};
  const size_t vertices = mesh.positions.size() / 3, joints = rig_.skins[skin].joints.size();
  skinned.joints.resize(vertices * skinned.influences, 0);
  skinned.weights.resize(vertices * skinned.influences, 0.0f);
  for (uint32_t set = 0; set < sets; ++set) read_set(primitive, set, mesh.name, joints, skinned);
  for (size_t v = 0; v < vertices; ++v) normalize(&skinned.weights[v * skinned.influences], skinned.influences);
  rig_.skinned.push_back(std::move(skinned));
  return true;
}

void SkinReader::read_set(const tinygltf::Primitive& primitive, uint32_t set, const std::string& name, size_t joints,
                          SkinnedMesh& skinned) {
  const size_t vertices = skinned.positions.size() / 3;
  const auto values = [&](const char* attribute) {
    const std::string key = fmt::format("{}_{}", attribute, set);
    return read_floats(file_, primitive.attributes.at(key), 4, vertices, fmt::format("mesh {}, {}", name, key));
  };
  const std::vector<float> joint = values("JOINTS"), weight = values("WEIGHTS");
  for (size_t i = 0; i < joint.size(); ++i) {
    const size_t to = i / 4 * skinned.influences + 4 * set + i % 4;
    skinned.weights[to] = weight[i];
    if (joint[i] >= 0.0f && joint[i] < static_cast<float>(joints)) {
      skinned.joints[to] = static_cast<uint16_t>(joint[i]);
    } else if (weight[i] > 0.0f) {
      refuse("cannot read {}: mesh {} hangs on joint {} of {}; export it again", file_.path, name, joint[i], joints);
    }
  }
}

}  // namespace sideray::scenes::gltf
