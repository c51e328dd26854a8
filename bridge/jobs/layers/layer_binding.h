// Binds the newest layers of a view to a host's program, for the snippet's sideray_find() and its like. GL thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "bridge/jobs/layers/layer_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// Describes the space of the program's positions to the snippet.
struct LayerSpace {
  glm::dvec3 origin;  // origin of the program's positions; 0 = world space
  float subpixel;     // the most that the rasterizer snaps a vertex, in pixels
};

// Offset of the whole pixels' units, behind the three of layers and the two of masks.
inline constexpr uint32_t whole_units = 5;
bool reads_whole_pixels(const gl::Functions& gl, uint32_t program);

// Throws Failure (INVALID_ARGUMENT) where the program reads surface ids of another type than the newest layers hold:
// OpenGL would return undefined ids without an error. `checked` caches programs that passed for a type.
struct CheckedProgram {
  uint32_t program;
  bool float_ids;
  bool operator==(const CheckedProgram&) const = default;
};
void check_id_sampler(const gl::Functions& gl, uint32_t program, const LayerJob& job, std::vector<CheckedProgram>& checked);

// `program` must be in use. Binds the layers to units first_unit .. first_unit + 2, or 0 where there are none: "no
// answer". If the program reads whole pixels, binds them to first_unit + whole_units and the next. The caller restores
// the active unit.
void bind_layers(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const LayerJob& job,
                 const LayerSpace& space);

}  // namespace sideray::bridge
