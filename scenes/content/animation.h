// Holds how a scene moves: its nodes, the channels that animate them, and what is attached to them. Made by the loader,
// then immutable. Any thread.
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

// Returns a node's rotation and translation without its scale, because glTF scales neither cameras nor lights. Not
// finite if the matrix has no rotation.
glm::dmat4 without_scale(const glm::dmat4& world_from_node);

struct RigNode {
  int parent = -1;  // comes before it in the list
  bool is_animated = false, moves = false;
  bool is_morphing = false;  // a channel changes its weights
  bool is_hidden = false;    // at rest, with its subtree (KHR_node_visibility)
  bool blinks = false;       // a channel hides it or an ancestor
  glm::dmat4 parent_from_node{1.0};  // for nodes without animation
  Placement rest;                    // values that no channel changes
};

struct Skin {
  std::vector<uint32_t> joints;             // nodes
  std::vector<glm::dmat4> joint_from_mesh;  // inverse bind matrices
};

// A mesh of a single object that is skinned into world space.
struct SkinnedMesh {
  uint32_t mesh = 0, skin = 0;
  int morphed = -1;                                 // index in Rig::morphed: the mesh that is blended before skinning
  std::vector<float> positions, normals, tangents;  // before skinning
  uint32_t influences = 0;                          // a vertex
  std::vector<uint16_t> joints;                     // into Skin::joints
  std::vector<float> weights;                       // of each vertex: >= 0, with the sum 1
};

// Attaches Content::objects, cameras or lights [index] to a node.
struct Attached {
  uint32_t index = 0, node = 0;
  glm::dmat4 node_from_it{1.0};
  bool is_in_world = false;  // skinned: it is in world space, whatever its node's transform
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
// Returns whether an object with this transform can be drawn and traced.
bool can_be_inverted(const glm::dmat4& m);

}  // namespace sideray::scenes
