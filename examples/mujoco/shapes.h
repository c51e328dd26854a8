// Triangles of MuJoCo's geoms. Glass is seen by rays alone, and may be as fine as one likes.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

struct Shape {
  std::vector<float> positions, normals, uv;  // of triangles, three vertices each
};

// Planes, spheres, capsules, ellipsoids, cylinders, boxes and meshes have one; height fields, skins and decoration do not.
bool has_shape(const mjvGeom& geom);

// In the geom's frame: capsules and meshes as they are, all else 2 units large, to be scaled by the geom's size.
Shape shape_of(const mjModel& model, const mjvGeom& geom);
