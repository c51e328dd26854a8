// Holds a scene as read from a file or generated: `info` prints it, and it fills a sideray::Scene. Any thread.
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
  float aspect = 0;  // width / height in the file, 0 = none; only for a warning, since pictures have their own size
};

struct Light {
  std::string name;  // the node's; "sun" for the default light; "lightI" where empty or not unique
  sideray_light light;
};

enum class RayTraced { by_default, yes, no };  // extras.sideray.rayTraced

struct Material {
  std::string name;
  sideray_material_desc desc;  // texture slots hold index + 1 into Content::textures
  RayTraced ray_traced = RayTraced::by_default;
  bool inexact_shadow = false;  // extras.sideray.inexactShadow: its shadow rays skip a little of their start
};

struct Texture {
  std::string name;
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;  // top row first
  bool srgb = false;
};

struct Mesh {
  std::string name;
  std::vector<float> positions, normals, tangents, uv0, uv1, colors;  // 3, 3, 4, 2, 2, 4 a vertex; empty = absent
  std::vector<uint32_t> indices;
  sideray_topology topology = SIDERAY_TRIANGLES;
};

// Holds one drawn primitive. Its surface id in the scene is its index in Content::objects + 1.
struct Object {
  std::string name;                 // the node's name, for --ray-traced patterns
  uint32_t mesh = 0, material = 0;  // indices into Content
  double world_from_object[12] = {};
  uint32_t wind = 0;     // index + 1 into Content::winds, 0 = no wind
  float wind_phase = 0;  // 0..1
};

struct Animation {
  std::string name;  // "animationI" where the file has none
  double length_s = 0;
};

class Rig;  // animation.h

struct Content {
  std::string name;
  uint64_t hash = 0;  // of all bytes of the files read for it; 0 = no file
  std::vector<Mesh> meshes;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Object> objects;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  std::vector<sideray_wind_desc> winds;  // extras.sideray.wind of nodes
  std::vector<Emitter> emitters;         // where load() placed them; pose() does not move them
  std::vector<Animation> animations;
  std::vector<std::string> variants;  // of materials (KHR_materials_variants)
  std::vector<std::string> extensions, defaulted;
  Warnings warnings;
  std::shared_ptr<const Rig> rig;  // moves the content; null where nothing moves
};

// Thrown for a scene of an unknown kind; the message names the known ones.
struct UnknownScene : Error {
  using Error::Error;
};

struct LoadOptions {
  std::string animation;  // "" = the first one, "all" = all of them; they loop
  std::string variant{};  // of materials; "" = those that the primitives themselves name
  double time_s = 0;
  bool default_light = true;  // adds a sun if a file has no light
  ReadLimits limits{};
};

// Thrown where there is no such animation; the message names the existing ones.
struct UnknownAnimation : Error {
  using Error::Error;
};

// Thrown where there is no such variant, likewise.
struct UnknownVariant : Error {
  using Error::Error;
};

// Returns whether the name could be the path of a .gltf or .glb file or of a folder, which need not exist.
bool may_be_file(const std::string& scene);
// Reads a .gltf or .glb file; builtin.h loads built-in scenes too. Throws Error with one clear line.
Content load_file(const std::string& path, const LoadOptions& options = {});

// Throws UnknownAnimation where the content has no animation of that name; "" and "all" are always valid.
void check_animation(const Content& content, const std::string& name);
// Throws UnknownVariant where the content has no variant of that name; "" is always valid.
void check_variant(const Content& content, const std::string& name);

// Moves objects, skinned meshes, lights, cameras and particles to their places at that time. Only the number of
// particles may change.
void pose(Content& content, double time_s);

// Writes binary glTF 2.0, whole or not at all, which load() reads back as equal content. Throws Error.
void write_glb(const std::string& path, const Content& content);

// Return what `info` prints: the JSON of cli.md with counts and the names of translucent objects, and a text of the
// same.
std::string info_json(const Content& content);
std::string info_text(const Content& content);

// Copies the content into `scene` and commits. `traced[i]` says whether objects[i] gets SIDERAY_VISIBLE_LAYERS.
void fill(Scene& scene, const Content& content, const std::vector<bool>& traced);

// Returns whether anything in the content changes over time.
bool moves(const Content& content);
// Applies the changes of pose() to `scene`, and commits if there were any. `scene` must hold what fill() gave it, and
// nothing else. Wind follows Scene::set_time() instead.
void move(Scene& scene, const Content& content);

// Changes the `traced` of fill(), and commits. `scene` must hold what fill() gave it, and nothing else.
void set_traced(Scene& scene, const Content& content, const std::vector<bool>& traced);

// Returns which objects are selected by `selection`: "auto" (as marked in the file, else transmission, and blending of
// roughness < 0.5), "all" (all but multiply), "none", "largest:K", or comma-separated glob patterns on node names.
// Throws Error on an unknown form or a pattern that matches nothing.
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
