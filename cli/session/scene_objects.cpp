#include "cli/session/scene_objects.h"

#include <algorithm>

namespace sideray::cli {
namespace {

bool is_same_node(const scenes::Object& a, const scenes::Object& b) {
  return a.name == b.name && std::equal(std::begin(a.world_from_object), std::end(a.world_from_object),
                                        std::begin(b.world_from_object));
}

}  // namespace

std::vector<SceneObject> scene_objects(const scenes::Content& content) {
  std::vector<SceneObject> objects;
  for (size_t i = 0; i < content.objects.size(); ++i) {
    const scenes::Object& object = content.objects[i];
    if (i == 0 || !is_same_node(content.objects[i - 1], object)) objects.push_back({object.name, {}});
    objects.back().surfaces.push_back(static_cast<uint32_t>(i + 1));
    const sideray_material_desc& material = content.materials[object.material].desc;
    objects.back().translucent |= material.alpha_mode == SIDERAY_BLEND || material.transmission > 0.0f;
  }
  return objects;
}

}  // namespace sideray::cli
