// A scene as read from a file or generated: what `info` prints and what fills a sideray::Scene. Any thread.
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
  float aspect = 0;  // width / height as the file says; 0 = it does not. Only for a warning: the picture's size decides
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

// One drawn primitive. The surface id given to the scene is its index in Content::objects + 1.
struct Object {
  std::string name;                 // the node's name, for --ray-traced patterns
  uint32_t mesh = 0, material = 0;  // indices into Content
  double world_from_object[12] = {};
  uint32_t wind = 0;     // index + 1 into Content::winds, 0 = it stands still
  float wind_phase = 0;  // 0..1
};

struct Animation {
  std::string name;  // "animationI" where the file has none
  double length_s = 0;
};

class Rig;  // animation.h

struct Content {
  std::string name;
  uint64_t hash = 0;  // of every byte of the files read for it; 0 = none was
  std::vector<Mesh> meshes;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Object> objects;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  std::vector<sideray_wind_desc> winds;  // extras.sideray.wind of nodes
  std::vector<Emitter> emitters;         // where load() had them; pose() leaves them there
  std::vector<Animation> animations;
  std::vector<std::string> variants;  // of materials (KHR_materials_variants)
  std::vector<std::string> extensions, defaulted;
  Warnings warnings;
  std::shared_ptr<const Rig> rig;  // what moves it; null where nothing does
};

// The scene is of no kind that is known; the message names what there is.
struct UnknownScene : Error {
  using Error::Error;
};

struct LoadOptions {
  std::string animation;  // "" = the first one, "all" = all of them; they loop
  std::string variant{};  // of materials; "" = those that the primitives themselves name
  double time_s = 0;
  bool default_light = true;  // a sun where a file has no light
  ReadLimits limits{};
};

// The animation asked for is not there; the message names those that are.
struct UnknownAnimation : Error {
  using Error::Error;
};

// The same of a variant.
struct UnknownVariant : Error {
  using Error::Error;
};

// Whether it is the path of a .gltf or .glb file, or of a folder; there need not be one.
bool may_be_file(const std::string& scene);
// Reads a .gltf or .glb file; builtin.h loads built-in scenes too. Throws Error with one clear line.
Content load_file(const std::string& path, const LoadOptions& options = {});

// Throws UnknownAnimation where the content has no animation by that name; "" and "all" are always there.
void check_animation(const Content& content, const std::string& name);
// Throws UnknownVariant where the content has no variant by that name; "" is always there.
void check_variant(const Content& content, const std::string& name);

// Moves objects, skinned meshes, lights and cameras to where the animations have them at that time, and particles to
// where they are by then. Of all but particles, what is drawn of the content stays as many.
void pose(Content& content, double time_s);

// Binary glTF 2.0 that load reads back as equal content, written whole or not at all. Throws Error.
void write_glb(const std::string& path, const Content& content);

// What `info` prints: the JSON of cli.md with counts and the names of translucent objects, and the same for people.
std::string info_json(const Content& content);
std::string info_text(const Content& content);

// Copies the content into `scene` and commits. `traced[i]` says whether objects[i] gets SIDERAY_VISIBLE_LAYERS.
void fill(Scene& scene, const Content& content, const std::vector<bool>& traced);

// Whether anything of it is another at another time.
bool moves(const Content& content);
// Moves what pose() has moved, and commits where that was anything. `scene` holds what fill() gave it, and nothing
// else. Wind is where Scene::set_time() said.
void move(Scene& scene, const Content& content);

// Changes what fill() said, and commits. `scene` holds what fill() gave it, and nothing else.
void set_traced(Scene& scene, const Content& content, const std::vector<bool>& traced);

// `selection`: "auto" (marks, else smooth translucency: roughness < 0.5), "all" (all but multiply), "none",
// "largest:K", or comma-separated glob patterns on node names. Throws Error on an unknown form or a pattern that
// matches nothing.
std::vector<bool> select_ray_traced(const Content& content, const std::string& selection, const sideray_camera& camera,
                                    uint32_t width, uint32_t height);

// The camera that frames the default scene (cli.md, Camera).
sideray_camera framing_camera(const Content& content, float aspect);
sideray_camera look_at(const double eye[3], const double target[3], float fov_deg);

// The built-in lat-long sky, top row first, RGB.
struct Sky {
  uint32_t width, height;
  std::vector<float> rgb;
};
Sky sky();

}  // namespace sideray::scenes
