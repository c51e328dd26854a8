// Declares the inside of the glTF loader: a file whose structure passed all checks, and its readers. Any thread.
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
  Budget& budget;              // remaining time and memory
  uint64_t hash = empty_hash;  // of every byte read for it
  std::map<size_t, std::string> broken_images{};  // index -> reason; no bytes were read
  std::set<size_t> broken_cameras{};              // of an unknown type, or without values of their type
};

// Reads the file, and the files of its own folder that it names. `budget` must outlive the result. Throws Error.
File read(const std::string& path, Budget& budget);

// Both replace compressed geometry by plain buffers and accessors, so that later steps need not know it. Throw Error.
void decode_meshopt(File& file);
void decode_draco(File& file);
int add_buffer(File& file, std::vector<uint8_t> bytes);  // returns its index

// Returns the cause in an Error about the file, for a warning: the message without the file and the remedy.
std::string reason_of(const Error& error, const File& file);

// Returns the index, after checking that it is below `count`. Throws Error, which names the element and the index.
size_t checked_index(const File& file, int index, size_t count, const char* kind, const std::string& user);

// Both return the numbers of `value` at `key`, or `fallback`. Throw Error where one is not a finite number.
double number(const File& file, const tinygltf::Value& value, const char* key, double fallback);
std::vector<double> numbers(const File& file, const tinygltf::Value& value, const char* key,
                            std::vector<double> fallback);
// Returns the extension's object, or null.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);
// Returns extras.sideray, or null.
const tinygltf::Value* sideray_extras(const tinygltf::Value& extras);

// Returns an accessor's elements as floats, `components` for each; normalized integers become -1..1 or 0..1, and sparse
// elements are substituted. `expected_count` 0 = any. Throws Error.
std::vector<float> read_floats(const File& file, int accessor, uint32_t components, size_t expected_count,
                               const std::string& user);
std::vector<uint32_t> read_unsigned(const File& file, int accessor, const std::string& user);
size_t accessor_count(const File& file, int accessor, const std::string& user);
// Returns the number of components of an element: 1 for SCALAR, 3 for VEC3.
uint32_t accessor_components(const File& file, int accessor, const std::string& user);


// Returns a primitive as triangles, lines or points; it has no indices where there is nothing to draw. Adds warnings to
// `content`.
Mesh read_primitive(const File& file, const tinygltf::Primitive& primitive, const std::string& name, Content& content);

// Holds a node of the default scene, placed at the requested time. Nodes of the rig have the same order and indices:
// parents before children, else as in the file.
struct PlacedNode {
  size_t node;
  glm::dmat4 world_from_node;
  bool moves = false;
  bool is_hidden = false;  // by KHR_node_visibility, at all times: it is not read
  uint32_t first_object = 0, object_count = 0;  // of Content::objects, set by read_objects()
};
// Fills rig.nodes; the nodes stand at rest.
std::vector<PlacedNode> place_nodes(const File& file, Rig& rig, Content& content);

// KHR_materials_volume_scatter.
struct Scattering {
  glm::dvec3 color;  // of an infinitely thick body
  double anisotropy;
};
// Returns the extension of a material, if it has any. Throws Error, which names `user`.
std::optional<Scattering> read_scattering(const File& file, const tinygltf::Material& source, const std::string& user,
                                          Content& content);

// Appends all materials, in the file's order, and their textures. A broken material that no node shows gets the
// defaults and a warning. Returns the scattering of those that have it, by the materials' indices.
std::map<uint32_t, Scattering> read_materials(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Lists the variants of materials, and gives each primitive its material of the variant `wanted`
// (LoadOptions::variant), so that later steps need not know variants. Throws Error and UnknownVariant.
void apply_variant(File& file, const std::string& wanted, Content& content);

// Holds an animated value of a material, light or camera (gltf_pointer.h).
struct PointerTarget;
struct AnimatedValue {
  std::shared_ptr<const PointerTarget> target;
  Channel channel;
};

// Lists all animations, and reads `wanted` of them (LoadOptions::animation). Adds channels of nodes to the rig, and
// returns those of other values. Throws UnknownAnimation.
std::vector<AnimatedValue> read_animations(const File& file, const std::vector<PlacedNode>& nodes,
                                           const std::string& wanted, Rig& rig, Content& content);

// Returns the number of morph targets of a node's mesh; 0 where it has no mesh.
size_t target_count(const File& file, const tinygltf::Node& node);
// Returns the targets' weights in the node, or else in its mesh, or else 0. Throws Error.
std::vector<double> rest_weights(const File& file, const tinygltf::Node& node, const std::string& name,
                                 Content& content);
// Returns the primitive's morph targets for `mesh`, which was read from it.
std::shared_ptr<const MorphTargets> read_targets(const File& file, const tinygltf::Primitive& primitive,
                                                 const Mesh& mesh, Content& content);

class SkinReader {
 public:
  SkinReader(const File& file, std::span<const PlacedNode> nodes, Rig& rig);
  // Returns the skin's index in Rig::skins; reads each skin once.
  uint32_t skin(int index, const std::string& user);
  // Attaches content.meshes[content_mesh] to the skin. Returns false where the primitive has no joints.
  bool read(const tinygltf::Primitive& primitive, uint32_t skin, uint32_t content_mesh, const Mesh& mesh,
            Content& content);

 private:
  void read_inverse_bind_matrices(int accessor, const std::string& what, Skin& skin);
  void read_set(const tinygltf::Primitive& primitive, uint32_t set, const std::string& name, size_t joints,
                SkinnedMesh& skinned);

  const File& file_;
  Rig& rig_;
  std::vector<int> rig_node_;  // for each node of the file; -1 = not in the scene
  std::map<int, uint32_t> skins_;
};

// Holds the instances of a node (EXT_mesh_gpu_instancing), or the node itself as a single one.
struct Instances {
  std::vector<glm::dmat4> node_from_instance;
  std::vector<float> wind_phases;        // 0..1; empty = the node has no wind or gives none
  std::vector<uint32_t> object_indices;  // empty = the node gives none
};
Instances read_instances(const File& file, const tinygltf::Node& node, const std::string& name, Content& content);
bool has_wind_phases(const tinygltf::Node& node);

// Warns of broken images. The scene shows none of them: their users were refused or left out before.
void warn_of_unused_images(const File& file, Content& content);

// Each adds animated items to the rig. read_objects() returns for each object its place in the scene's order, or
// any_place.
constexpr uint32_t any_place = UINT32_MAX;
std::vector<uint32_t> read_objects(const File& file, std::span<PlacedNode> nodes, Rig& rig, Content& content);
// Maps a light or camera of the file to one of the content, on a node of the rig.
struct ReadThing {
  size_t of_file;
  uint32_t node, of_content;
};
std::vector<ReadThing> read_cameras(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
std::vector<ReadThing> read_lights(const File& file, std::span<const PlacedNode> nodes, Rig& rig, Content& content);
// Reads the winds and emitters of nodes.
void read_node_extras(const File& file, std::span<const PlacedNode> nodes, Content& content);

// Puts objects in their places; those with any_place fill the gaps, in the file's order. PlacedNode::first_object
// becomes invalid.
void order_objects(std::span<const uint32_t> places, Rig& rig, Content& content);
// Multiplies thickness, which files give in the mesh's space, by the scale of the material's objects.
// `thickness_varies` lists materials that may get a thickness later. Returns the scaled materials: for the first scale
// the source itself, for others copies.
struct ScaledMaterial {
  uint32_t source, material;  // of Content::materials
  float scale;
};
std::vector<ScaledMaterial> scale_thickness(const std::set<uint32_t>& thickness_varies, Content& content);

// Approximates scattering, at the materials' thickness, by their other properties. `scaled` lists all materials with a
// thickness.
void show_scattering(const std::map<uint32_t, Scattering>& scattering, std::span<const ScaledMaterial> scaled,
                     Content& content);

Content load(const std::string& path, const LoadOptions& options);

}  // namespace sideray::scenes::gltf
