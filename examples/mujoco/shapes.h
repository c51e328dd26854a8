// Makes triangles of MuJoCo's geoms. Only rays see glass, so its meshes may be finer than MuJoCo's.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

struct Shape {
  std::vector<float> positions, normals, uv;  // of triangles, three vertices each
};

// Returns whether the geom is a plane, sphere, capsule, ellipsoid, cylinder, box or mesh, not a height field, a skin or
// decoration.
bool has_shape(const mjvGeom& geom);

// Returns the shape in the geom's frame: capsules and meshes in their size, others 2 units large, to be scaled by the
// geom's size.
Shape shape_of(const mjModel& model, const mjvGeom& geom);
