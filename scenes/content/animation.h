// Describes how a scene moves: its nodes, the channels that animate them, and the objects attached to them. The loader
// makes it; afterwards it is only read. Any thread.
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

// Returns the matrix without its scale, since glTF scales neither cameras nor lights. The result is not finite where no
// rotation can be found.
glm::dmat4 without_scale(const glm::dmat4& world_from_node);

struct RigNode {
  int parent = -1;  // earlier in the list
  bool is_animated = false, moves = false;
  bool is_morphing = false;  // a channel changes its weights
  bool is_hidden = false;    // at rest, with all below it (KHR_node_visibility)
  bool blinks = false;       // a channel hides it, or a node above it
  glm::dmat4 parent_from_node{1.0};  // if the node is not animated
  Placement rest;                    // values that no channel changes
};

struct Skin {
  std::vector<uint32_t> joints;             // nodes
  std::vector<glm::dmat4> joint_from_mesh;  // inverse bind matrices
};

// A mesh that belongs to one object alone and is skinned into world space.
struct SkinnedMesh {
  uint32_t mesh = 0, skin = 0;
  int morphed = -1;                                 // index into Rig::morphed, whose blended mesh is skinned; -1 = none
  std::vector<float> positions, normals, tangents;  // before skinning
  uint32_t influences = 0;                          // joints of each vertex
  std::vector<uint16_t> joints;                     // into Skin::joints
  std::vector<float> weights;                       // of each vertex: >= 0, sum 1
};

// Attaches Content::objects, cameras or lights [index] to a node.
struct Attached {
  uint32_t index = 0, node = 0;
  glm::dmat4 node_from_it{1.0};
  bool is_in_world = false;  // skinned into world space: its node's transform does not apply
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
// Returns whether an object with this placement can be drawn and traced.
bool can_be_inverted(const glm::dmat4& m);

}  // namespace sideray::scenes
