// Holds the rasterizer's programs, each compiled at its first use, and defines their binding points. The context must
// be current.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/program.h"

namespace sideray::gl {

// Texture units, each of one sampler type: two types on a unit are an error at the draw.
namespace unit {
inline constexpr uint32_t environment_specular = 0, environment_irradiance = 1, albedo_terms = 2;
inline constexpr uint32_t directional_shadows = 3, local_shadows = 4;
inline constexpr uint32_t layer_cache = 5;     // .. 7; the G-buffer resolve reads masks and other results of rays here
inline constexpr uint32_t material = 8;        // .. 26; the G-buffer resolve and the composite use these too
inline constexpr uint32_t order_keys = 27;     // of depth peeling, on drivers that have so many units
inline constexpr uint32_t many_lights = 28;    // for more lights than uniform blocks hold, likewise
inline constexpr uint32_t tint_maps = 30;      // .. 31; likewise
inline constexpr uint32_t opaque_levels = 29;  // of surfaces that bend light, likewise
}  // namespace unit

namespace block {
inline constexpr uint32_t material = 0, lights = 1, shadows = 2;
}

// In a set of textures, bit k is set where slot k of model/material_slots.h may have one. To keep programs few, a
// surface takes the smallest of four sets that holds its own, or else every slot that some surface of the scene has
// (`scene_maps`); white textures fill the slots it lacks.
inline constexpr uint32_t base_color_map = 0x0001, coat_maps = 0x0e00, sheen_maps = 0x3000, behind_maps = 0xc000,
                          film_maps = 0x30000, anisotropy_maps = 0x40000;
uint32_t map_set_for(uint32_t maps, uint32_t scene_maps);
// Returns the slots that fit beside the other textures; of the others only the factors are drawn.
uint32_t available_maps(uint32_t texture_units);

// Lobes beyond metallic-roughness, bits of the define SR_LOBES. A lobe has code, targets and cost only where some
// surface has it.
namespace lobe {
inline constexpr uint32_t coat = 1, sheen = 2, behind = 4;
inline constexpr uint32_t count = 3;  // of the three above: each takes a target of the G-buffer
inline constexpr uint32_t in_targets = coat | sheen | behind;
inline constexpr uint32_t film = 8;         // changes f0, so that the G-buffer holds f0 for all surfaces
inline constexpr uint32_t anisotropy = 16;  // the G-buffer's ids also hold its direction and strength
}  // namespace lobe

// Says what lights opaque pixels besides shadow maps.
struct LightInputs {
  bool masks = false, answers = false;  // `answers`: some pixels have no masks
  bool tints = false, tint_maps = false;
};

// Says what translucent surfaces look up besides layers.
struct TranslucentInputs {
  bool aside = false;  // the opaque picture, for a surface that refracts or blurs
  bool tint_maps = false;
};

struct Shading {
  uint32_t maps = 0;   // set of textures
  uint32_t lobes = 0;  // set of lobe::*
  bool wind = false;   // its vertices move: RasterScene::set_wind
};

// Says what a translucent fragment writes: SR_ORDER of shaders/translucent/raster_order.glsl.
enum class FragmentOrder : uint32_t {
  blended = 0,
  slice = 1,
  listed = 2,
  key = 3
};

struct SpriteShading {
  bool lit = false, soft = false;
  bool hidden = false;  // may be behind surfaces that bend light, which the layer cache tells
};

// All but `all` look up the layer cache; misassigned also the true layers; asking requests the second wave.
enum class CountedFragments { all, matched, missed, misassigned, asking };

struct Coverage {
  bool alpha = false;  // discards fragments in holes
  CountedFragments counted = CountedFragments::all;
  bool wind = false;
  bool rest = false;    // writes the place where rays hit the surface
  bool motion = false;  // writes motion vectors
};

class RasterPrograms {
 public:
  explicit RasterPrograms(const Functions& gl) : gl_(gl) {}

  // Sets whether programs read lights from a texture, from now on.
  void set_many_lights(bool many) { many_lights_ = many; }

  // `holes`: for surfaces that may have some. For other surfaces drivers test depth before they shade.
  const Program& gbuffer(Shading shading, bool holes);
  const Program& translucent(Shading shading, FragmentOrder order, TranslucentInputs inputs);
  const Program& coverage(Coverage variant);
  const Program& sprites(SpriteShading shading, FragmentOrder order);
  const Program& sprite_coverage();
  const Program& light(uint32_t lobes, const LightInputs& inputs);
  const Program& tint_map(Shading shading);
  const Program& composite();
  const Program& whole();
  const Program& motion_of_view();
  const Program& temporal();
  // Draw the offsets of surfaces that distort, and the picture shifted by them.
  const Program& distort(uint32_t maps, bool wind);
  const Program& distort_picture();
  // Full-screen programs of the orders in order_*.cpp.
  const Program& peel_start();
  const Program& resolve_lists();

 private:
  struct Parts {
    std::vector<std::string> vertices, fragments, defines;
    const char* version = "330 core";
  };
  // Returns the vertex stage of programs that draw surfaces, in wind or not.
  static Parts surface(bool wind, std::vector<std::string> fragments, std::vector<std::string> defines);
  static Parts ordered(Parts parts, FragmentOrder order, const char* file);
  const Program& get(const std::string& name, const Parts& parts);

  const Functions& gl_;
  std::map<std::string, Program> programs_;
  bool many_lights_ = false;
};

}  // namespace sideray::gl
