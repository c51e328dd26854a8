// The rasterizer's programs, each compiled when it is first asked for, and the binding points that they agree on.
// The context must be current.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gl/functions.h"
#include "gl/program.h"

namespace sideray::gl {

inline constexpr uint32_t material_maps = 7;

// Texture units. One sampler type each: two types on a unit are an error at the draw.
namespace unit {
inline constexpr uint32_t material = 0;  // .. 6; the G-buffer resolve and the composite use these too
inline constexpr uint32_t environment_specular = 7, environment_irradiance = 8, albedo_terms = 9;
inline constexpr uint32_t directional_shadows = 10, local_shadows = 11;
inline constexpr uint32_t layer_cache = 12;  // .. 14
}  // namespace unit

namespace block {
inline constexpr uint32_t material = 0, lights = 1, shadows = 2;
}

// Programs are made for four sets of textures, so that a scene compiles few of them; a surface takes the smallest set
// that holds its own, and white textures fill the rest.
inline constexpr uint32_t map_sets[] = {0x00, 0x01, 0x1f, 0x7f};
uint32_t map_set_for(uint32_t maps);  // index into map_sets

struct Coverage {
  bool alpha = false;          // leaves absent fragments out
  bool count_matches = false;  // looks the layer cache up
};

class RasterPrograms {
 public:
  explicit RasterPrograms(const Functions& gl) : gl_(gl) {}

  const Program& gbuffer(uint32_t map_set);
  const Program& translucent(uint32_t map_set);
  const Program& coverage(Coverage variant);
  const Program& light();
  const Program& composite();

 private:
  struct Parts {
    std::string vertex;
    std::vector<std::string> fragments, defines;
  };
  const Program& get(const std::string& name, const Parts& parts);

  const Functions& gl_;
  std::map<std::string, Program> programs_;
};

}  // namespace sideray::gl
