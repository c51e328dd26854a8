// Describes a committed scene: plain, immutable data that the rasterizer and the tracer both read. Any thread may read
// it.
#pragma once

#include <sideray/sideray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

namespace sideray::model {

struct Bounds {
  glm::vec3 minimum{INFINITY}, maximum{-INFINITY};
  bool empty() const { return minimum.x > maximum.x; }
  void add(glm::vec3 p) {
    minimum = glm::min(minimum, p);
    maximum = glm::max(maximum, p);
  }
  glm::vec3 center() const { return 0.5f * (minimum + maximum); }
  float radius() const { return empty() ? 0.0f : 0.5f * glm::length(maximum - minimum); }
};

// Holds the triangles, lines or points of one primitive in object space. Every vector of attributes has one entry per
// vertex: absent attributes get their defaults when the mesh is added, so that readers need no branches.
struct Mesh {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec4> tangents;  // w = +-1 bitangent sign; 0 without a tangent frame
  std::vector<glm::vec2> uv0, uv1;
  std::vector<glm::vec4> colors;
  std::vector<glm::uvec3> triangles;  // lines and points repeat their last vertex
  std::vector<uint32_t>
      source_primitive;  // number as given by the caller, if some were dropped; otherwise empty
  Bounds bounds;
  bool has_colors = false, has_tangents = false;
  float minimum_alpha = 1.0f;  // the lowest of the vertex colours
  sideray_topology topology = SIDERAY_TRIANGLES;
};

// Holds an RGBA8 image, top row first, with all mip levels (level k is max(1, size >> k)), box-filtered in linear
// light.
struct Texture {
  struct Level {
    uint32_t width, height;
    std::vector<uint8_t> rgba;
  };
  std::vector<Level> levels;
  bool srgb = false;
  uint8_t minimum_alpha = 255;  // the lowest of level 0
  uint8_t minimum_green = 255;  // the lowest of level 0
};

struct Material {
  sideray_material_desc desc;  // texture slots hold index + 1 into Snapshot::textures, 0 = none
  bool translucent;            // BLEND or transmission > 0
  bool cull_back;              // not double sided
  bool discards;               // an alpha below 1/255 (BLEND) or the cut-off (MASK) can occur
  bool traceable;              // translucent and not multiply: may have layers
  bool mirrors;                // opaque, and smooth enough somewhere to reflect by rays
  // For the fixed function: its material, and which factors of alpha are ignored.
  sideray_fixed_material fixed;
  bool without_factor_alpha, without_vertex_alpha, without_texel_alpha;
};

// Holds a sideray_wind_desc for sr_wind() of shaders/shading/wind.h; object space.
struct Wind {
  sideray_wind_desc desc;
};

struct Instance {
  uint32_t mesh, material;  // indices into the snapshot
  glm::mat4x3 local_from_object;
  glm::mat3 normal_from_object;  // inverse transpose; normalize the product
  bool mirrored;                 // negative determinant: the front face is the clockwise one
  bool solid;                    // a closed mesh around a volume (transmission, thickness): front faces are its outside
  bool shell;                    // a closed mesh of thin glass with two sides, which encloses light
  uint32_t surface_id, visibility;
  Bounds bounds;      // local space
  uint32_t wind = 0;  // index + 1 into the snapshot's winds, 0 = no wind
  float wind_phase = 0;
  uint32_t sprites = 0;  // index + 1 of the system that these quads show (rt/poses/particle_quads.h); 0 = none
  uint64_t user = 0;     // the host's own number
};

struct Light {
  sideray_light_type type;
  glm::vec3 position, direction;  // local space; direction is unit, in which the light travels
  glm::vec3 intensity;
  float range, cos_inner, cos_outer;
  float radius;          // radius of a sphere about the position; point and spot
  float angular_radius;  // radians; directional
  float filter_radius;   // pixels; not positive: its mask is not filtered
  uint32_t filter_frames;
  bool operator==(const Light&) const = default;
};

// Holds a sideray_fixed_light.
struct FixedLight {
  glm::vec3 place;  // local space; if `distant`, the unit direction to it
  bool distant;
  glm::vec3 ambient, diffuse, specular;
  glm::vec3 axis;  // unit direction in which the light travels
  float exponent, cos_cutoff;
  glm::vec3 attenuation;  // constant, linear, quadratic
  bool casts_shadows;
  bool operator==(const FixedLight&) const = default;
};

// Holds the light model of the fixed function of OpenGL 1.x.
struct FixedFunction {
  std::vector<FixedLight> lights;
  glm::vec3 ambient;
  bool local_viewer, two_sided, separate_specular;
  bool operator==(const FixedFunction&) const = default;
};

// Describes a camera-facing sprite: half the width, along the camera's x turned by the rotation; half the height.
struct Sprite {
  glm::vec3 position;  // local space
  glm::vec2 half_size;
  float rotation;  // radians
  glm::vec4 color;
  uint32_t cell;  // in the flip-book, in range
};

struct ParticleSystem {
  sideray_particles_desc desc;  // texture holds index + 1 into Snapshot::textures, 0 = none
  std::vector<Sprite> sprites;
};

// Holds lat-long images, RGB float, top row first. Lookups: sr_latlong in shaders/shading/shading.h. `rotation` and
// `scale` are already applied. All are black if there is no environment.
struct Environment {
  struct Image {
    uint32_t width = 0, height = 0;
    std::vector<glm::vec3> texels;
  };
  std::vector<Image>
      specular;      // level l is prefiltered for perceptual roughness l / (levels - 1); level 0 is the input
  Image irradiance;  // E / pi: multiply by the diffuse colour
  float mean = 0;    // of radiance over all directions and channels
  bool black = true;
  bool uniform = false;  // radiance is the same from all directions
};

// Holds the host's name of an object. `reuse` distinguishes objects that had the same name at different times.
struct Name {
  uint32_t name = 0, reuse = 0;
  bool operator==(const Name&) const = default;
};

// Holds the names of a snapshot's objects, which are sorted by name. Objects that the library has added after them have
// none (0).
struct Names {
  std::vector<Name> all;  // empty: each name is the index + 1, and was never reused
  Name operator[](size_t index) const {
    if (all.empty()) return {static_cast<uint32_t>(index + 1), 0};
    return index < all.size() ? all[index] : Name{};
  }
  bool operator==(const Names&) const = default;
};

inline constexpr uint32_t no_index = 0xffffffffu;

// Returns the index of the object with this name and `reuse` among `count` objects; no_index if there is none.
inline uint32_t find_name(const Names& names, size_t count, Name name) {
  if (names.all.empty()) return name.reuse == 0 && name.name - 1 < count ? name.name - 1 : no_index;
  const auto found = std::lower_bound(names.all.begin(), names.all.end(), name.name,
                                      [](const Name& n, uint32_t wanted) { return n.name < wanted; });
  return found != names.all.end() && *found == name ? static_cast<uint32_t>(found - names.all.begin()) : no_index;
}

// Returns the index of the object that has a name now, whatever its `reuse`; no_index if there is none.
inline uint32_t find_name(const Names& names, size_t count, uint32_t name) {
  if (names.all.empty()) return name - 1 < count ? name - 1 : no_index;
  const auto found = std::lower_bound(names.all.begin(), names.all.end(), name,
                                      [](const Name& n, uint32_t wanted) { return n.name < wanted; });
  return found != names.all.end() && found->name == name ? static_cast<uint32_t>(found - names.all.begin()) : no_index;
}

// Positions are "local": world position minus `origin`, so that floats stay precise far from the world's origin.
// Indices change between commits when objects are removed, so that two snapshots are compared by names.
struct Snapshot {
  glm::dvec3 origin{0.0};
  Names mesh_names, material_names, instance_names;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::vector<std::shared_ptr<const Texture>> textures;
  std::vector<Material> materials;
  std::vector<Instance> instances;
  std::vector<Instance> thin;  // instances of lines and points, which no ray hits; opaque
  std::vector<Wind> winds;
  double time_s = 0, previous_time_s = 0;  // for the wind
  std::vector<Light> lights;
  std::vector<ParticleSystem> particles;
  std::shared_ptr<const Environment> environment;  // never null
  sideray_shader_desc shader{};                    // without a function: the built-in model
  std::shared_ptr<const void> shader_use;          // once released, nobody calls the shader any more
  std::shared_ptr<const FixedFunction> fixed;      // null: the built-in model, or the shader
  Bounds bounds;
  uint64_t revision = 0;  // grows with every commit
};

// Holds the directional albedo of the specular lobe in split-sum form, albedo = f0 * x + f90 * y, and that of a white
// sheen lobe, z. A square table: row i is for perceptual roughness i / (size - 1), column i for n.v i / (size - 1).
// Computed when the project is built (make_albedo_table.cpp).
struct AlbedoTable {
  static constexpr uint32_t size = 64;
  std::vector<glm::vec3> values;  // size * size
};
const AlbedoTable& albedo_table();

}  // namespace sideray::model
