// Holds a scene read from a file or generated, which `info` prints and which fills a sideray::Scene. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "scenes/base/budget.h"
#include "scenes/content/particles.h"

namespace sideray::scenes {

struct Camera {
  std::string name;
  sideray_camera camera;
  float aspect = 0;  // width / height in the file; 0 = unspecified. Only for a warning: the picture's size decides
};

struct Light {
  std::string name;  // the node's; "sun" for the default light; "lightI" if empty or not unique
  sideray_light light;
};

enum class RayTraced { by_default, yes, no };  // extras.sideray.rayTraced

struct Material {
  std::string name;
  sideray_material_desc desc;  // texture slots hold index + 1 into Content::textures
  RayTraced ray_traced = RayTraced::by_default;
  bool inexact_shadow = false;  // extras.sideray.inexactShadow: marks it for the inexact shadow test
};

struct Texture {
  std::string name;
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;  // top row first
  bool srgb = false;
};

struct Mesh {
  std::string name;
  std::vector<float> positions, normals, tangents, uv0, uv1, colors;  // 3, 3, 4, 2, 2, 4 numbers a vertex; empty =
                                                                      // absent
  std::vector<uint32_t> indices;
  sideray_topology topology = SIDERAY_TRIANGLES;
};

// One drawn primitive. Its surface id in the scene is its index in Content::objects + 1.
struct Object {
  std::string name;                 // the node's name, for --ray-traced patterns
  uint32_t mesh = 0, material = 0;  // indices into Content
  double world_from_object[12] = {};
  uint32_t wind = 0;     // index + 1 into Content::winds, 0 = none
  float wind_phase = 0;  // 0..1
};

struct Animation {
  std::string name;  // "animationI" if the file has no name
  double length_s = 0;
};

class Rig;  // animation.h

struct Content {
  std::string name;
  uint64_t hash = 0;  // of every byte of the files read; 0 = none was read
  std::vector<Mesh> meshes;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Object> objects;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  std::vector<sideray_wind_desc> winds;  // extras.sideray.wind of nodes
  std::vector<Emitter> emitters;         // as load() placed them; pose() does not move them
  std::vector<Animation> animations;
  std::vector<std::string> variants;  // of materials (KHR_materials_variants)
  std::vector<std::string> extensions, defaulted;
  Warnings warnings;
  std::shared_ptr<const Rig> rig;  // animations; null if nothing moves
};

// The scene is of no known kind; the message names the known ones.
struct UnknownScene : Error {
  using Error::Error;
};

struct LoadOptions {
  std::string animation;  // "" = the first one, "all" = all of them; they loop
  std::string variant{};  // of materials; "" = the primitives' own materials
  double time_s = 0;
  bool default_light = true;  // adds a sun to a file without lights
  ReadLimits limits{};
};

// The requested animation does not exist; the message names the existing ones.
struct UnknownAnimation : Error {
  using Error::Error;
};

// The same for a variant.
struct UnknownVariant : Error {
  using Error::Error;
};

// Returns whether it is the path of a .gltf or .glb file, or of a folder, which need not exist.
bool may_be_file(const std::string& scene);
// Reads a .gltf or .glb file; builtin.h loads built-in scenes too. Throws Error with one clear line.
Content load_file(const std::string& path, const LoadOptions& options = {});

// Throws UnknownAnimation if the content has no animation of that name; "" and "all" always exist.
void check_animation(const Content& content, const std::string& name);
// Throws UnknownVariant if the content has no variant of that name; "" always exists.
void check_variant(const Content& content, const std::string& name);

// Moves objects, skinned meshes, lights and cameras to their animated state at that time, and particles to theirs.
// Except for particles, the number of drawn things stays the same.
void pose(Content& content, double time_s);

// Writes binary glTF 2.0, which load reads back as equal content, completely or not at all. Throws Error.
void write_glb(const std::string& path, const Content& content);

// Return what `info` prints: the JSON of cli.md with counts and the names of translucent objects, and a readable text.
std::string info_json(const Content& content);
std::string info_text(const Content& content);

// Copies the content into `scene` and commits. `traced[i]` says whether objects[i] gets SIDERAY_VISIBLE_LAYERS.
void fill(Scene& scene, const Content& content, const std::vector<bool>& traced);

// Returns whether anything in it changes over time.
bool moves(const Content& content);
// Moves in `scene` what pose() has moved, and commits if that was anything. `scene` must hold exactly what fill()
// added. Scene::set_time() sets the wind's time.
void move(Scene& scene, const Content& content);

// Changes the `traced` of fill(), and commits. `scene` must hold exactly what fill() added.
void set_traced(Scene& scene, const Content& content, const std::vector<bool>& traced);

// Returns for each object whether it is ray traced. `selection`: "auto" (by marks, else smooth translucency: roughness
// < 0.5), "all" (all but multiply), "none", "largest:K", or comma-separated glob patterns for node names. Throws Error
// for an unknown form or a pattern that matches nothing.
std::vector<bool> select_ray_traced(const Content& content, const std::string& selection, const sideray_camera& camera,
                                    uint32_t width, uint32_t height);

// Returns the camera that frames the default scene (cli.md, Camera).
sideray_camera framing_camera(const Content& content, float aspect);
sideray_camera look_at(const double eye[3], const double target[3], float fov_deg);

// The built-in lat-long sky, top row first, RGB.
struct Sky {
  uint32_t width, height;
  std::vector<float> rgb;
};
Sky sky();

}  // namespace sideray::scenes
