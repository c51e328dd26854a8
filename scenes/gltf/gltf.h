// Declares the internals of the glTF loader: a file that passed all checks of its structure, and readers of its parts.
// Any thread.
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
  Budget& budget;              // the time and memory that reading may still use
  uint64_t hash = empty_hash;  // of every byte of the files that were read
  std::map<size_t, std::string> broken_images{};  // the reason for each image that cannot be used; none of its bytes
                                                  // were read
  std::set<size_t> broken_cameras{};              // of an unknown type, or without the values that their type needs
};

// Reads the file and all files that it names, from its own folder only. `budget` must outlive the result. Throws Error.
File read(const std::string& path, Budget& budget);

// Replace compressed geometry by plain buffers and accessors, so that later steps need no special case. Throw Error.
void decode_meshopt(File& file);
void decode_draco(File& file);
int add_buffer(File& file, std::vector<uint8_t> bytes);  // returns its index

// Returns the cause from an Error about the file, for a warning: the message without the file and the remedy.
std::string reason_of(const Error& error, const File& file);

// Returns the index after checking that it is inside the list. Throws Error, which names the element and the index.
size_t checked_index(const File& file, int index, size_t count, const char* kind, const std::string& user);

// Return the number or numbers of `value` at `key`, or `fallback` if the key is absent. Throw Error if one is not a
// finite number.
double number(const File& file, const tinygltf::Value& value, const char* key, double fallback);
std::vector<double> numbers(const File& file, const tinygltf::Value& value, const char* key,
                            std::vector<double> fallback);
// Returns the extension's object, or null.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);
// Returns extras.sideray, or null.
const tinygltf::Value* sideray_extras(const tinygltf::Value& extras);

// Returns an accessor's elements as floats, `components` for each; normalized integers become -1..1 or 0..1, and sparse
// substitutions are applied. `expected_count` 0 accepts any count. Throws Error.
std::vector<float> read_floats(const File& file, int accessor, uint32_t components, size_t expected_count,
                               const std::string& user);
std::vector<uint32_t> read_unsigned(const File& file, int accessor, const std::string& user);
size_t accessor_count(const File& file, int accessor, const std::string& user);
// Returns the number of components of one element: 1 for SCALAR, 3 for VEC3.
uint32_t accessor_components(const File& file, int accessor, const std::string& user);


// Returns one primitive as triangles, lines or points, with no indices if nothing of it can be drawn. Warnings go to
// `content`.
Mesh read_primitive(const File& file, const tinygltf::Primitive& primitive, const std::string& name, Content& content);

// A node of the default scene, at its place at the requested time. Nodes of the rig have the same order and indices:
// parents before children, otherwise as in the file.
struct PlacedNode {
  size_t node;
  glm::dmat4 world_from_node;
  bool moves = false;
  bool is_hidden = false;  // by KHR_node_visibility, at all times: nothing of the node is read
  uint32_t first_object = 0, object_count = 0;  // of Content::objects, valid after they are read
};
// Fills rig.nodes and returns the nodes in their rest pose.
std::vector<PlacedNode> place_nodes(const File& file, Rig& rig, Content& content);

// Holds the values of KHR_materials_volume_scatter.
struct Scattering {
  glm::dvec3 color;  // of an infinitely thick body of the material
  double anisotropy;
};
// Returns the extension of a material, if it has any. Throws Error, which names `user`.
std::optional<Scattering> read_scattering(const File& file, const tinygltf::Material& source, const std::string& user,
                                          Content& content);

// Appends all materials, in the file's order, and the textures they use. A broken material that no node uses becomes
// the default one, with a warning. Returns which materials scatter, by index.
std::map<uint32_t, Scattering> read_materials(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Lists the material variants in the content and gives each primitive its material in the `wanted` one
// (LoadOptions::variant), so that later steps need not know variants. Throws Error and UnknownVariant.
void apply_variant(File& file, const std::string& wanted, Content& content);

// A value of a material, light or camera that a channel animates (gltf_pointer.h).
struct PointerTarget;
struct AnimatedValue {
  std::shared_ptr<const PointerTarget> target;
  Channel channel;
};

// Lists all animations and applies the `wanted` ones (LoadOptions::animation): those of nodes become channels of the
// rig, the others are returned. Throws UnknownAnimation.
std::vector<AnimatedValue> read_animations(const File& file, const std::vector<PlacedNode>& nodes,
                                           const std::string& wanted, Rig& rig, Content& content);

// Returns the number of morph targets of a node's mesh; 0 if it has no mesh.
size_t target_count(const File& file, const tinygltf::Node& node);
// Returns the targets' weights from the node, else from its mesh, else 0. Throws Error.
std::vector<double> rest_weights(const File& file, const tinygltf::Node& node, const std::string& name,
                                 Content& content);
// Returns the primitive's morph targets for `mesh`, which was read from it.
std::shared_ptr<const MorphTargets> read_targets(const File& file, const tinygltf::Primitive& primitive,
                                                 const Mesh& mesh, Content& content);

class SkinReader {
 public:
  SkinReader(const File& file, std::span<const PlacedNode> nodes, Rig& rig);
  // Returns the index into Rig::skins. A skin is read once.
  uint32_t skin(int index, const std::string& user);
  // Attaches content.meshes[content_mesh] to the skin. Returns false if the primitive has no joints.
  bool read(const tinygltf::Primitive& primitive, uint32_t skin, uint32_t content_mesh, const Mesh& mesh,
            Content& content);

 private:
  void read_inverse_bind_matrices(int accessor, const std::string& what, Skin& skin);
  void read_set(const tinygltf::Primitive& primitive, uint32_t set, const std::string& name, size_t joints,
                SkinnedMesh& skinned);

  const File& file_;
  Rig& rig_;
  std::vector<int> rig_node_;  // by node of the file; -1 if it is not in the scene
  std::map<int, uint32_t> skins_;
};

// The instances of a node (EXT_mesh_gpu_instancing), or one instance that is the node itself.
struct Instances {
  std::vector<glm::dmat4> node_from_instance;
  std::vector<float> wind_phases;        // 0..1; empty if the node has no wind or gives none
  std::vector<uint32_t> object_indices;  // empty if the node gives none
};
Instances read_instances(const File& file, const tinygltf::Node& node, const std::string& name, Content& content);
bool has_wind_phases(const tinygltf::Node& node);

// Warns of broken images that nothing uses; whatever uses one was refused or left out before.
void warn_of_unused_images(const File& file, Content& content);

// These read what nodes carry, and add animated parts to the rig. read_objects() returns each object's place in the
// scene's order, or any_place.
constexpr uint32_t any_place = UINT32_MAX;
std::vector<uint32_t> read_objects(const File& file, std::span<PlacedNode> nodes, Rig& rig, Content& content);
// Links a light or camera of the content with its index in the file and its node of the rig.
struct ReadThing {
  size_t of_file;
  uint32_t node, of_content;
};
std::vector<ReadThing> read_cameras(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
std::vector<ReadThing> read_lights(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
// Reads winds and particle emitters.
void read_node_extras(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Moves objects to their places; objects without one fill the free places in the file's order. PlacedNode::first_object
// is invalid afterwards.
void order_objects(std::span<const uint32_t> places, Rig& rig, Content& content);
// Multiplies thickness, which the file gives in the mesh's space, by the scale of the objects that use the material.
// `thickness_varies`: materials that an animation can give a thickness. Returns the scaled materials and their scales;
// the first one of a source is the source itself.
struct ScaledMaterial {
  uint32_t source, material;  // of Content::materials
  float scale;
};
std::vector<ScaledMaterial> scale_thickness(const std::set<uint32_t>& thickness_varies, Content& content);

// Approximates scattering inside a body by other material properties. `scaled`: all materials with a thickness.
void show_scattering(const std::map<uint32_t, Scattering>& scattering, std::span<const ScaledMaterial> scaled,
                     Content& content);

Content load(const std::string& path, const LoadOptions& options);

}  // namespace sideray::scenes::gltf
