// Inside of the glTF loader: a file that passed all checks of its frame, and what is read out of it. Any thread.
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "scenes/base/budget.h"
#include "scenes/base/files.h"
#include "scenes/content/animation.h"
#include "scenes/content/content.h"

namespace sideray::scenes::gltf {

struct File {
  std::string path;
  tinygltf::Model model;  // buffers loaded; images hold their encoded bytes
  Warnings warnings;
  Budget& budget;              // what reading may still take
  uint64_t hash = empty_hash;  // of every byte read for it
  std::map<size_t, std::string> broken_images{};  // why each cannot be had; nothing was read for it
  std::set<size_t> broken_cameras{};              // of no known type, or without what their type wants
};

// Reads the file and everything it names, from its own folder only. `budget` must stay. Throws Error.
File read(const std::string& path, Budget& budget);

// Replace compressed geometry by plain buffers and accessors, so that no later step knows of it. Throw Error.
void decode_meshopt(File& file);
void decode_draco(File& file);
int add_buffer(File& file, std::vector<uint8_t> bytes);  // its index

// What an Error about the file says of its cause, for a warning: the message without the file and the remedy.
std::string reason_of(const Error& error, const File& file);

// The index, once it is inside the list. Throws Error that names the element and the index.
size_t checked_index(const File& file, int index, size_t count, const char* kind, const std::string& user);

// Numbers of `value` at `key`, or `fallback`. Throws Error where it is not a finite number.
double number(const File& file, const tinygltf::Value& value, const char* key, double fallback);
std::vector<double> numbers(const File& file, const tinygltf::Value& value, const char* key,
                            std::vector<double> fallback);
// The extension's object, or null.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);
// extras.sideray, or null.
const tinygltf::Value* sideray_extras(const tinygltf::Value& extras);

// An accessor's elements as floats, `components` an element; normalized integers become -1..1 or 0..1, sparse ones are
// put in. `expected_count` 0 = any. Throws Error.
std::vector<float> read_floats(const File& file, int accessor, uint32_t components, size_t expected_count,
                               const std::string& user);
std::vector<uint32_t> read_unsigned(const File& file, int accessor, const std::string& user);
size_t accessor_count(const File& file, int accessor, const std::string& user);
// Number of components of one element: 1 for SCALAR, 3 for VEC3.
uint32_t accessor_components(const File& file, int accessor, const std::string& user);


// One primitive as triangles; without indices it has none to draw. Warnings go to `content`.
Mesh read_primitive(const File& file, const tinygltf::Primitive& primitive, const std::string& name, Content& content);

// A node of the default scene, as it stands at the requested time. Nodes of the rig have the same order and indices:
// parents before children, as in the file.
struct PlacedNode {
  size_t node;
  glm::dmat4 world_from_node;
  bool moves = false;
  bool is_hidden = false;  // by KHR_node_visibility, at any time: nothing of it is read
  uint32_t first_object = 0, object_count = 0;  // of Content::objects, once they are read
};
// Fills rig.nodes; the nodes stand at rest.
std::vector<PlacedNode> place_nodes(const File& file, Rig& rig, Content& content);

// KHR_materials_volume_scatter.
struct Scattering {
  glm::dvec3 color;  // that an endlessly thick body of it has
  double anisotropy;
};
// Throws Error, which names the `user`.
std::optional<Scattering> read_scattering(const File& file, const tinygltf::Material& source, const std::string& user,
                                          Content& content);

// Appends all materials, in the file's order, and the textures they use. One that is broken and on no node gets the
// defaults and a warning. Returns what scatters, by the materials' indices.
std::map<uint32_t, Scattering> read_materials(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Lists the variants of materials, and gives each primitive the material that it has in `wanted` of them
// (LoadOptions::variant), so that no later step knows of them. Throws Error and UnknownVariant.
void apply_variant(File& file, const std::string& wanted, Content& content);

// A value of a material, light or camera that a channel changes (gltf_pointer.h).
struct PointerTarget;
struct AnimatedValue {
  std::shared_ptr<const PointerTarget> target;
  Channel channel;
};

// Lists all animations and plays `wanted` of them (LoadOptions::animation): those of nodes by channels of the rig.
// Returns the others. Throws UnknownAnimation.
std::vector<AnimatedValue> read_animations(const File& file, const std::vector<PlacedNode>& nodes,
                                           const std::string& wanted, Rig& rig, Content& content);

// Number of morph targets of a node's mesh; 0 where it has no mesh.
size_t target_count(const File& file, const tinygltf::Node& node);
// The weights that the node, or else its mesh, gives them; 0 where neither does. Throws Error.
std::vector<double> rest_weights(const File& file, const tinygltf::Node& node, const std::string& name,
                                 Content& content);
// What the primitive adds to `mesh`, which is read from it.
std::shared_ptr<const MorphTargets> read_targets(const File& file, const tinygltf::Primitive& primitive,
                                                 const Mesh& mesh, Content& content);

class SkinReader {
 public:
  SkinReader(const File& file, std::span<const PlacedNode> nodes, Rig& rig);
  // Index into Rig::skins, read once.
  uint32_t skin(int index, const std::string& user);
  // Hangs content.meshes[content_mesh] on the skin. False where the primitive has no joints.
  bool read(const tinygltf::Primitive& primitive, uint32_t skin, uint32_t content_mesh, const Mesh& mesh,
            Content& content);

 private:
  void read_inverse_bind_matrices(int accessor, const std::string& what, Skin& skin);
  void read_set(const tinygltf::Primitive& primitive, uint32_t set, const std::string& name, size_t joints,
                SkinnedMesh& skinned);

  const File& file_;
  Rig& rig_;
  std::vector<int> rig_node_;  // of each node of the file; -1 = not in the scene
  std::map<int, uint32_t> skins_;
};

// The instances of a node (EXT_mesh_gpu_instancing), or the node itself as one.
struct Instances {
  std::vector<glm::dmat4> node_from_instance;
  std::vector<float> wind_phases;        // 0..1; empty = the node has no wind or gives none
  std::vector<uint32_t> object_indices;  // empty = the node gives none
};
Instances read_instances(const File& file, const tinygltf::Node& node, const std::string& name, Content& content);
bool has_wind_phases(const tinygltf::Node& node);

// Says which images that cannot be had were of no use to anybody; whatever wanted one was refused or left out before.
void warn_of_unused_images(const File& file, Content& content);

// Each adds what moves to the rig. read_objects returns for each object its place in the scene's order, or any_place.
constexpr uint32_t any_place = UINT32_MAX;
std::vector<uint32_t> read_objects(const File& file, std::span<PlacedNode> nodes, Rig& rig, Content& content);
// Which light or camera of the content is one of the file, on a node of the rig.
struct ReadThing {
  size_t of_file;
  uint32_t node, of_content;
};
std::vector<ReadThing> read_cameras(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
std::vector<ReadThing> read_lights(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
// Winds and emitters.
void read_node_extras(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Puts objects to their places; those that have none fill what is free, in the file's order. PlacedNode::first_object
// holds no longer.
void order_objects(std::span<const uint32_t> places, Rig& rig, Content& content);
// Multiplies thickness, which the file gives in the mesh's space, by the scale of the objects that have the material.
// `thickness_varies`: materials that may get one later. Returns what has been scaled; the first of a source is itself.
struct ScaledMaterial {
  uint32_t source, material;  // of Content::materials
  float scale;
};
std::vector<ScaledMaterial> scale_thickness(const std::set<uint32_t>& thickness_varies, Content& content);

// Gives materials that scatter, of their thickness, what comes near to that. `scaled`: all that have a thickness.
void show_scattering(const std::map<uint32_t, Scattering>& scattering, std::span<const ScaledMaterial> scaled,
                     Content& content);

Content load(const std::string& path, const LoadOptions& options);

}  // namespace sideray::scenes::gltf
