// How a scene moves: its nodes, the channels that animate them, and what hangs on them. Made by the loader, read only
// afterwards. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "scenes/content/animated_values.h"
#include "scenes/content/content.h"
#include "scenes/content/morph.h"

namespace sideray::scenes {

struct Placement {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
};
glm::dmat4 matrix_of(const Placement& placement);

// Rotation and place of a node without its scale: glTF lets neither cameras nor lights be scaled. Not finite where
// there is no rotation in it.
glm::dmat4 without_scale(const glm::dmat4& world_from_node);

struct RigNode {
  int parent = -1;  // stands before it in the list
  bool is_animated = false, moves = false;
  bool is_morphing = false;  // a channel changes its weights
  bool is_hidden = false;    // at rest, with all below it (KHR_node_visibility)
  bool blinks = false;       // a channel hides it, or a node above it
  glm::dmat4 parent_from_node{1.0};  // where it is not animated
  Placement rest;                    // what channels leave alone
};

struct Skin {
  std::vector<uint32_t> joints;             // nodes
  std::vector<glm::dmat4> joint_from_mesh;  // inverse bind matrices
};

// A mesh that belongs to one object alone and is skinned into world space.
struct SkinnedMesh {
  uint32_t mesh = 0, skin = 0;
  int morphed = -1;                                 // of Rig::morphed: what is blended before it is bent
  std::vector<float> positions, normals, tangents;  // unbent
  uint32_t influences = 0;                          // a vertex
  std::vector<uint16_t> joints;                     // into Skin::joints
  std::vector<float> weights;                       // of each vertex: >= 0, sum 1
};

// Content::objects, cameras or lights [index] hangs on a node.
struct Attached {
  uint32_t index = 0, node = 0;
  glm::dmat4 node_from_it{1.0};
  bool is_in_world = false;  // skinned: it stands in the world, whatever its node does
};

class Rig {
 public:
  std::vector<RigNode> nodes;
  std::vector<Channel> channels;
  std::vector<Skin> skins;
  std::vector<SkinnedMesh> skinned;
  std::vector<MorphedMesh> morphed;
  std::vector<Attached> objects, cameras, lights;
  std::vector<AnimatedMaterial> materials;
  std::vector<AnimatedLight> light_values;
  std::vector<AnimatedCamera> camera_values;

  std::vector<glm::dmat4> world_from_nodes(double time_s) const;
  std::vector<bool> hidden_nodes(double time_s) const;
  bool is_always_hidden(uint32_t node) const;
  std::vector<double> weights(const MorphedMesh& mesh, double time_s) const;
};

void place_light(sideray_light& light, const glm::dmat4& world_from_light);
void set_transform(Object& object, const glm::dmat4& world_from_object);
// Whether anything placed so can be drawn and traced.
bool can_be_inverted(const glm::dmat4& m);

}  // namespace sideray::scenes
