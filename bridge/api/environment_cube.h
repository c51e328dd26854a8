// Converts the six faces of a cube map to a lat-long picture, the form in which environments are stored. Any thread may
// call it.
#pragma once

#include <cstdint>
#include <vector>

namespace sideray::bridge {

struct LatLong {
  uint32_t width, height;
  std::vector<float> rgb;  // top row (+Y) first, centre = -Z, u grows toward +X
};

// `faces`, `cube_from_world`: see sideray_scene_set_environment_cube. Throws Failure where they are no cube map.
LatLong lat_long_of_cube(uint32_t side, const float* const faces[6], const float* cube_from_world);

}  // namespace sideray::bridge
