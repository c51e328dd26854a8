// Lists the objects of a scene as people count them: one for each node, with all its primitives. Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::cli {

struct SceneObject {
  std::string name;                // name of the node
  std::vector<uint32_t> surfaces;  // surface ids of its primitives
  bool translucent = false;
};

std::vector<SceneObject> scene_objects(const scenes::Content& content);

}  // namespace sideray::cli
