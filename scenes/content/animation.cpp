#include "scenes/content/animation.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "scenes/base/limits.h"
#include "scenes/content/rotation.h"

namespace sideray::scenes {
namespace {

glm::dquat quaternion(const glm::dvec4& v) {
  return {v.w, v.x, v.y, v.z};
}

// Scales a vector by a power of 2, which keeps its direction exactly, so that its largest coordinate is near 1: squares
// of 1e300 are infinite, and those of 1e-300 are 0.
glm::dvec3 near_one(const glm::dvec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return v;
  const int exponent = std::ilogb(largest);
  return {std::scalbn(v.x, -exponent), std::scalbn(v.y, -exponent), std::scalbn(v.z, -exponent)};
}

bool is_usable(const glm::dmat4& m) {
  for (int i = 0; i < 16; ++i)
    if (!(std::abs(m[i / 4][i % 4]) <= limits::coordinate)) return false;
  return true;
}

// The attributes before skinning; they must not be those of the skinned mesh itself.
struct Unbent {
  std::span<const float> positions, normals, tangents;
};

struct Vertices {
  const Unbent& source;
  Mesh& mesh;

  void bend(size_t vertex, const glm::dmat4& m) {
    const float* p = &source.positions[3 * vertex];
    const glm::dvec3 bent(m * glm::dvec4(p[0], p[1], p[2], 1.0));
    // A vertex whose new position is not finite or too far keeps its last one.
    if (glm::all(glm::lessThanEqual(glm::abs(bent), glm::dvec3(limits::coordinate))))
      store(&mesh.positions[3 * vertex], bent);
    const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
    if (!source.normals.empty()) {
      // The inverse transpose times a positive factor, which also exists for singular matrices.
      const float side = glm::dot(glm::cross(x, y), z) < 0.0 ? -1.0f : 1.0f;
      const float* n = &source.normals[3 * vertex];
      store_unit(&mesh.normals[3 * vertex], double{side * n[0]} * glm::cross(y, z) +
                                                double{side * n[1]} * glm::cross(z, x) +
                                                double{side * n[2]} * glm::cross(x, y));
    }
    if (!source.tangents.empty()) {
      const float* t = &source.tangents[4 * vertex];
      store_unit(&mesh.tangents[4 * vertex], double{t[0]} * x + double{t[1]} * y + double{t[2]} * z);
    }
  }

  static void store(float* to, const glm::dvec3& v) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(v[c]);
  }
  // Stores the normalized vector. A vector of length 0 leaves the stored one.
  static void store_unit(float* to, const glm::dvec3& v) {
    const double length = glm::length(v);
    if (length > 1e-30 && std::isfinite(length)) store(to, v / length);
  }
};

void bend(const SkinnedMesh& skinned, const Unbent& source, const Skin& skin, const std::vector<glm::dmat4>& world,
          Mesh& mesh) {
  std::vector<glm::dmat4> world_from_mesh(skin.joints.size());
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    world_from_mesh[j] = world[skin.joints[j]] * skin.joint_from_mesh[j];
    if (!is_usable(world_from_mesh[j])) return;
  }
  Vertices vertices{source, mesh};
  for (size_t v = 0; v < source.positions.size() / 3; ++v) {
    glm::dmat4 m(0.0);
    for (size_t i = v * skinned.influences; i < (v + 1) * skinned.influences; ++i) {
      if (skinned.weights[i] > 0.0f) m += double{skinned.weights[i]} * world_from_mesh[skinned.joints[i]];
    }
    vertices.bend(v, m);
  }
}

// Blends morph targets, then applies skins.
void deform(Content& content, const Rig& rig, const std::vector<glm::dmat4>& world, double time_s) {
  std::vector<Mesh> blended(rig.morphed.size());
  for (size_t i = 0; i < rig.morphed.size(); ++i) {
    const MorphedMesh& morphed = rig.morphed[i];
    blend(morphed.base, *morphed.targets, rig.weights(morphed, time_s), blended[i]);
  }
  for (const SkinnedMesh& skinned : rig.skinned) {
    Mesh& mesh = content.meshes[skinned.mesh];
    Unbent source{skinned.positions, skinned.normals, skinned.tangents};
    if (skinned.morphed >= 0) {
      Mesh& shape = blended[static_cast<size_t>(skinned.morphed)];
      source = {shape.positions, shape.normals, shape.tangents};
      mesh.uv0.swap(shape.uv0), mesh.uv1.swap(shape.uv1), mesh.colors.swap(shape.colors);
    }
    bend(skinned, source, rig.skins[skinned.skin], world, mesh);
  }
  for (size_t i = 0; i < rig.morphed.size(); ++i) {
    if (rig.morphed[i].is_skinned) continue;
    Mesh& mesh = content.meshes[rig.morphed[i].mesh];
    blended[i].name.swap(mesh.name), blended[i].indices.swap(mesh.indices);
    blended[i].topology = mesh.topology;
    std::swap(mesh, blended[i]);
  }
}

// Returns a placement that makes an object too small to see. It has an inverse, which tracing and shading need.
glm::dmat4 invisible_at(const glm::dvec4& place) {
  constexpr double invisible = 1e-9;
  return {glm::dvec4(invisible, 0, 0, 0), glm::dvec4(0, invisible, 0, 0), glm::dvec4(0, 0, invisible, 0), place};
}

glm::dmat4 drawable(const glm::dmat4& m) {
  return can_be_inverted(m) ? m : invisible_at(m[3]);
}

}  // namespace

glm::dmat4 matrix_of(const Placement& placement) {
  glm::dmat4 matrix = glm::mat4_cast(placement.rotation);
  for (int c = 0; c < 3; ++c) matrix[c] *= placement.scale[c];
  matrix[3] = glm::dvec4(placement.translation, 1.0);
  return matrix;
}

glm::dmat4 without_scale(const glm::dmat4& m) {
  const glm::dvec3 y = near_one(m[1]), z = near_one(m[2]);
  const glm::dvec3 back = glm::normalize(z), right = glm::normalize(glm::cross(y, z)), up = glm::cross(back, right);
  const glm::dmat4 result(glm::dvec4(right, 0), glm::dvec4(up, 0), glm::dvec4(back, 0), m[3]);
  // A matrix that was already rigid keeps all its bits, so that writing and reading changes nothing.
  bool same = true;
  for (int i = 0; i < 12; ++i) same = same && std::abs(result[i / 4][i % 4] - m[i / 4][i % 4]) < 1e-14;
  return same ? m : result;
}

std::vector<glm::dmat4> Rig::world_from_nodes(double time_s) const {
  std::vector<Placement> placements(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) placements[i] = nodes[i].rest;
  for (const Channel& channel : channels) {
    const bool moves = channel.property == Property::translation || channel.property == Property::rotation ||
                       channel.property == Property::scale;
    if (!moves) continue;
    const glm::dvec4 value = sample(channel, time_s);
    Placement& placement = placements[channel.node];
    if (channel.property == Property::translation) placement.translation = glm::dvec3(value);
    if (channel.property == Property::rotation) placement.rotation = quaternion(value);
    if (channel.property == Property::scale) placement.scale = glm::dvec3(value);
  }
  std::vector<glm::dmat4> world(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const RigNode& node = nodes[i];
    const glm::dmat4 parent_from_node = node.is_animated ? matrix_of(placements[i]) : node.parent_from_node;
    world[i] = node.parent < 0 ? parent_from_node : world[static_cast<size_t>(node.parent)] * parent_from_node;
  }
  return world;
}

std::vector<bool> Rig::hidden_nodes(double time_s) const {
  std::vector<bool> hidden(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) hidden[i] = nodes[i].is_hidden;
  for (const Channel& channel : channels)
    if (channel.property == Property::visible) hidden[channel.node] = sample(channel, time_s).x < 0.5;
  for (size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].parent >= 0 && hidden[static_cast<size_t>(nodes[i].parent)]) hidden[i] = true;
  return hidden;
}

bool Rig::is_always_hidden(uint32_t node) const {
  if (nodes[node].blinks) return false;
  for (int i = static_cast<int>(node); i >= 0; i = nodes[static_cast<size_t>(i)].parent)
    if (nodes[static_cast<size_t>(i)].is_hidden) return true;
  return false;
}

std::vector<double> Rig::weights(const MorphedMesh& mesh, double time_s) const {
  std::vector<double> weights = mesh.weights;
  for (const Channel& channel : channels)
    if (channel.property == Property::weights && channel.node == mesh.node) weights = sample_weights(channel, time_s);
  // Splines may overshoot far. The clamp keeps products with targets in the range of floats.
  for (double& weight : weights) weight = std::clamp(weight, -1e6, 1e6);
  return weights;
}

void set_transform(Object& object, const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r) object.world_from_object[3 * c + r] = m[c][r];
  }
}

bool can_be_inverted(const glm::dmat4& m) {
  return std::abs(glm::determinant(glm::dmat3(m))) > limits::smallest_determinant;
}

void pose(Content& content, double time_s) {
  simulate(content, time_s);
  if (content.rig == nullptr) return;
  const Rig& rig = *content.rig;
  const std::vector<glm::dmat4> world = rig.world_from_nodes(time_s);
  const std::vector<bool> hidden = rig.hidden_nodes(time_s);
  // An object whose new placement is not finite keeps its last one.
  for (const Attached& a : rig.objects) {
    const glm::dmat4 m = a.is_in_world ? glm::dmat4(1.0) : world[a.node] * a.node_from_it;
    if (is_usable(m)) set_transform(content.objects[a.index], hidden[a.node] ? invisible_at(m[3]) : drawable(m));
  }
  for (const Attached& a : rig.cameras) {
    const glm::dmat4 m = without_scale(world[a.node]);
    if (!is_usable(m)) continue;
    for (int i = 0; i < 12; ++i) content.cameras[a.index].camera.world_from_camera[i] = m[i / 3][i % 3];
  }
  for (const Attached& a : rig.lights) {
    const glm::dmat4 m = without_scale(world[a.node]);
    if (is_usable(m)) place_light(content.lights[a.index].light, m);
  }
  for (const AnimatedLight& a : rig.light_values) set_values(a, time_s, hidden[a.node], content);
  for (const AnimatedMaterial& a : rig.materials) set_values(a, time_s, content);
  for (const AnimatedCamera& a : rig.camera_values) set_values(a, time_s, content);
  deform(content, rig, world, time_s);
}

void place_light(sideray_light& light, const glm::dmat4& world_from_light) {
  for (int c = 0; c < 3; ++c) {
    light.direction[c] = static_cast<float>(-world_from_light[2][c]);
    if (light.type != SIDERAY_LIGHT_DIRECTIONAL) light.position[c] = world_from_light[3][c];
  }
}

}  // namespace sideray::scenes
