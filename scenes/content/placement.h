// Finds the world bounds of the objects of a Content. Any thread.
#pragma once

#include <glm/glm.hpp>

#include "scenes/content/content.h"

namespace sideray::scenes {

struct Bounds {
  glm::dvec3 minimum{INFINITY}, maximum{-INFINITY};
  bool empty() const { return minimum.x > maximum.x; }
};

// Both return the bounds of the vertices that triangles use.
Bounds bounds_of(const Content& content, const Object& object);
Bounds bounds_of(const Content& content);

}  // namespace sideray::scenes
