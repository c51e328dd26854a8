// Holds the data of a snapshot that surface kernels read (rt/surfaces/surface_lanes.h): plain numbers, and pointers
// into the snapshot. Names no types of GLM or the standard library. Immutable once built; any thread may read it.
#pragma once

#include <stdint.h>

#include "rt/surfaces/block_rows.h"

namespace sideray::rt {

// Holds an instance with its mesh's vertices.
struct alignas(64) InstanceRecord {
  float columns[4][4];                                   // local_from_object; the fourth row is 0
  float normal_columns[3][4];                            // normal_from_object
  const uint32_t* triangles;                             // three vertices each
  const float *positions, *normals, *tangents, *colors;  // 3, 3, 4, 4 floats each; tangents and colors are null if the
                                                         // mesh has none
  const float* uv[2];                                    // two floats each
  uint32_t material;
  bool mirrored, solid;
  bool sprites;  // kernels skip it
};

// Holds the words of an SrMaterial, in its order, and flags. Padded to a multiple of four rows.
struct alignas(16) MaterialRecord {
  static constexpr uint32_t words = 38, rows = 44;
  float shading[words];  // the last two are integers: alpha mode; all bits set if unlit
  float perturbs;        // 1: a normal map bends the normals
  float normal_scale, coat_normal_scale;
  float absorbs;  // 1: the volume absorbs light
  float framed;   // 1: its surface needs tangents
  uint32_t first_read, reads;
};

// Holds the words of an SrFixedMaterial, in its order.
struct alignas(16) FixedRecord {
  static constexpr uint32_t words = 36;
  float shading[words];
};

// Holds an SrFixedModel.
struct FixedModelTerms {
  float ambient[3], two_sided, separate;
};

struct LevelRecord {
  const uint8_t* rgba;
  int32_t width, height;
};

// Rows of a block that hold textures' values: the words of an SrTexels, in its order, then the two normals.
enum TexelRow : uint8_t {
  row_base_color = 0,
  row_emissive = 4,
  row_metallic = 7,
  row_roughness = 8,
  row_occlusion = 9,
  row_transmission = 10,
  row_thickness = 11,
  row_specular = 12,
  row_specular_color = 13,
  row_clearcoat = 16,
  row_clearcoat_roughness = 17,
  row_sheen_color = 18,
  row_sheen_roughness = 21,
  row_diffuse_transmission = 22,
  row_diffuse_transmission_color = 23,
  row_iridescence = 26,
  row_iridescence_thickness = 27,
  row_anisotropy_along = 28,
  row_anisotropy_across = 29,
  row_anisotropy = 30,
  row_normal = 31,
  row_coat_normal = 34,
  texel_rows = 37
};

// Describes a texture look-up. Look-ups with the same coordinates that serve several slots are merged.
struct alignas(16) ReadRecord {
  enum Wrap : int32_t { repeat, mirror, clamp };
  float map[6];         // of sideray_texture_slot
  float width, height;  // of the first level
  const LevelRecord* levels;
  uint32_t level_count;
  int32_t wrap[2];
  bool srgb, nearest, leveled;
  uint8_t uv_set;
  uint32_t first_output, outputs;
};

// Says which row receives a channel of a look-up, and how.
struct OutputRecord {
  enum class Use : uint8_t { plain, normal, occlusion };
  uint8_t channel, row;
  Use use;
  float strength;  // of occlusion
};

// Refers to a scene's records; `albedo` is model::AlbedoTable.
struct SurfaceTables {
  const InstanceRecord* instances;
  const MaterialRecord* materials;
  const ReadRecord* reads;
  const OutputRecord* outputs;
  const float* srgb;  // values of the 256 sRGB codes
  TexelView albedo;
  const FixedRecord* fixed;  // by material, in a scene of the fixed function; else null
  FixedModelTerms model;     // in a scene of the fixed function
};

// Holds sixteen hits, none of them on sprites.
struct alignas(64) HitBlock {
  BlockRow u, v;
  BlockRow direction[3];  // of the ray, unit
  BlockRow width;         // of its cone where it hits
  BlockRow front;         // 1: the front face
  uint32_t instance[block_size], primitive[block_size];
  const float* steps = nullptr;  // six numbers: PixelSteps of the view whose pixels the rays go through; may be null
};

}  // namespace sideray::rt
