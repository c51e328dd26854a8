// The objects of a scene as people count them: a node with all of its primitives. Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::cli {

struct SceneObject {
  std::string name;                // the node's
  std::vector<uint32_t> surfaces;  // ids of its primitives
  bool translucent = false;
};

std::vector<SceneObject> scene_objects(const scenes::Content& content);

}  // namespace sideray::cli
