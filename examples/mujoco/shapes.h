// Makes triangles of MuJoCo's geoms. Only rays draw glass, so its triangles may be as fine as needed.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

struct Shape {
  std::vector<float> positions, normals, uv;  // of separate triangles, three vertices each
};

// True for planes, spheres, capsules, ellipsoids, cylinders, boxes and meshes; false for height fields, skins and
// decoration.
bool has_shape(const mjvGeom& geom);

// Returns the shape in the geom's frame: capsules and meshes in full size, others 2 units large, to be scaled by the
// geom's size.
Shape shape_of(const mjModel& model, const mjvGeom& geom);
