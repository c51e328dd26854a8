#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

// Reads morph targets and their weights.
namespace sideray::scenes::gltf {
namespace {

struct Wanted {
  const char* attribute;
  uint32_t components;  // 0: a colour of 3 or 4
  std::vector<float> MorphTarget::*to;
  std::vector<float> Mesh::*base;
};

constexpr Wanted wanted[] = {{"POSITION", 3, &MorphTarget::positions, &Mesh::positions},
                             {"NORMAL", 3, &MorphTarget::normals, &Mesh::normals},
                             {"TANGENT", 3, &MorphTarget::tangents, &Mesh::tangents},
                             {"TEXCOORD_0", 2, &MorphTarget::uv0, &Mesh::uv0},
                             {"TEXCOORD_1", 2, &MorphTarget::uv1, &Mesh::uv1},
                             {"COLOR_0", 0, &MorphTarget::colors, &Mesh::colors}};

// Reads the values that a target adds; a colour without alpha adds 0 to alpha.
std::vector<float> read_added(const File& file, int accessor, uint32_t components, size_t vertices,
                              const std::string& user) {
  if (components != 0) return read_floats(file, accessor, components, vertices, user);
  if (accessor_components(file, accessor, user) == 4) return read_floats(file, accessor, 4, vertices, user);
  const std::vector<float> rgb = read_floats(file, accessor, 3, vertices, user);
  std::vector<float> rgba(vertices * 4, 0.0f);
  for (size_t v = 0; v < vertices; ++v) std::copy_n(&rgb[3 * v], 3, &rgba[4 * v]);
  return rgba;
}

void check_added(const File& file, const std::vector<float>& values, const std::string& user) {
  const auto usable = [](float x) { return std::abs(x) <= static_cast<float>(limits::coordinate); };
  if (!std::all_of(values.begin(), values.end(), usable))
    refuse("cannot read {}: {} has numbers that are not finite or beyond 1e15; correct it", file.path, user);
}

MorphTarget read_target(const File& file, const std::map<std::string, int>& source, const Mesh& mesh,
                        const std::string& user, std::set<std::string>& left_out) {
  if (source.empty()) refuse("cannot read {}: {} has no data; export it again", file.path, user);
  MorphTarget target;
  for (const Wanted& want : wanted) {
    const auto found = source.find(want.attribute);
    if (found == source.end()) continue;
    const std::string what = fmt::format("{}, {}", user, want.attribute);
    std::vector<float> values = read_added(file, found->second, want.components, mesh.positions.size() / 3, what);
    check_added(file, values, what);
    if ((mesh.*want.base).empty())
      left_out.insert(want.attribute);
    else if (std::any_of(values.begin(), values.end(), [](float x) { return x != 0.0f; }))
      target.*want.to = std::move(values);
  }
  return target;
}

std::vector<double> checked_weights(const File& file, const std::vector<double>& weights, size_t targets,
                                    const std::string& user) {
  if (weights.size() != targets)
    refuse("cannot read {}: {} has {} weights for {} morph targets; export it again", file.path, user, weights.size(),
           targets);
  // Larger weights could leave the range of floats when multiplied by targets.
  if (!std::all_of(weights.begin(), weights.end(), [](double w) { return std::abs(w) <= 1e6; }))
    refuse("cannot read {}: {} has a weight beyond 1e6; correct it", file.path, user);
  return weights;
}

}  // namespace

size_t target_count(const File& file, const tinygltf::Node& node) {
  const auto mesh = static_cast<size_t>(node.mesh);
  if (mesh >= file.model.meshes.size() || file.model.meshes[mesh].primitives.empty()) return 0;
  const auto& primitives = file.model.meshes[mesh].primitives;
  // Empty primitives have lost their targets, so the largest number of targets counts.
  const auto has_more = [](const tinygltf::Primitive& a, const tinygltf::Primitive& b) {
    return a.targets.size() < b.targets.size();
  };
  return std::max_element(primitives.begin(), primitives.end(), has_more)->targets.size();
}

std::vector<double> rest_weights(const File& file, const tinygltf::Node& node, const std::string& name,
                                 Content& content) {
  const size_t targets = target_count(file, node);
  const tinygltf::Mesh& mesh = file.model.meshes[static_cast<size_t>(node.mesh)];
  const std::string mesh_name = mesh.name.empty() ? fmt::format("mesh{}", node.mesh) : mesh.name;
  if (targets == 0 && !(node.weights.empty() && mesh.weights.empty()))
    content.warnings.push_back(fmt::format("node {}: it has weights and no morph targets; left out", name));
  if (targets == 0) return {};
  if (!node.weights.empty()) return checked_weights(file, node.weights, targets, "node " + name);
  if (!mesh.weights.empty()) return checked_weights(file, mesh.weights, targets, "mesh " + mesh_name);
  return std::vector<double>(targets, 0.0);
}

std::shared_ptr<const MorphTargets> read_targets(const File& file, const tinygltf::Primitive& primitive,
                                                 const Mesh& mesh, Content& content) {
  auto targets = std::make_shared<MorphTargets>();
  std::set<std::string> left_out;
  for (size_t t = 0; t < primitive.targets.size(); ++t)
    targets->push_back(
        read_target(file, primitive.targets[t], mesh, fmt::format("mesh {}, target {}", mesh.name, t), left_out));
  for (const std::string& attribute : left_out)
    content.warnings.push_back(
        fmt::format("mesh {}: its targets have {}, and it has none itself; left out", mesh.name, attribute));
  return targets;
}

}  // namespace sideray::scenes::gltf
