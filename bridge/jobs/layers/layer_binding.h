// Gives a host's program the newest layers of a view, for the snippet's sideray_find() and its kin. GL thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "bridge/jobs/layers/layer_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// Tells the snippet about positions, besides the layers.
struct LayerSpace {
  glm::dvec3 origin;  // where the program's positions are measured from; 0 = world space
  float subpixel;     // by how much of a pixel the rasterizer moves a vertex, at most
};

// Whole pixels are behind the layers' three units and the masks' two, for programs that read them.
inline constexpr uint32_t whole_units = 5;
bool reads_whole_pixels(const gl::Functions& gl, uint32_t program);

// Throws Failure (INVALID_ARGUMENT) where the program reads surface ids of another type than the newest layers hold: OpenGL
// would give it none, without an error. Programs that it found right for ids of a type are in `checked`.
struct CheckedProgram {
  uint32_t program;
  bool float_ids;
  bool operator==(const CheckedProgram&) const = default;
};
void check_id_sampler(const gl::Functions& gl, uint32_t program, const LayerJob& job, std::vector<CheckedProgram>& checked);

// `program` is in use. Binds the layers to units first_unit .. first_unit + 2, or 0 where there are none: "no answer";
// whole pixels, where the program reads them, to first_unit + whole_units and the next. The active unit is the caller's
// to put back.
void bind_layers(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const LayerJob& job,
                 const LayerSpace& space);

}  // namespace sideray::bridge
