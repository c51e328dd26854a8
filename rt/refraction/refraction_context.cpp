#include "rt/refraction/refraction_context.h"

#include <cstdint>
#include <vector>

namespace sideray::rt {

MediumStack media_at(const RefractionScene& scene, const Intersector& intersector, glm::vec3 point) {
  const Ray up{point, 0.0f, {0, 1, 0}, farthest};
  Hit hits[most_layers_in_round];
  uint32_t count = 0;
  intersector.nearest_layers(LayerSet::all_translucent, {&up, 1}, {.layers = most_layers_in_round, .cull = false}, hits,
                             &count);
  MediumStack entered;
  std::vector<uint32_t> around;  // the innermost first
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t instance = hits[i].instance;
    if (!scene.medium(instance).volume || !scene.surfaces.snapshot->instances[instance].solid) continue;
    if (hits[i].front)
      entered.push(instance);
    else if (entered.contains(instance))
      entered.remove(instance);
    else
      around.push_back(instance);
  }
  MediumStack media;
  for (size_t i = around.size(); i-- > 0;) media.push(around[i]);
  return media;
}

RefractionContext refraction_context(const FrameContext& frame, const RefractionScene& scene, bool exact) {
  RefractionContext context{&frame, &scene, {}, exact};
  if (frame.view->perspective()) context.at_eye = media_at(scene, *frame.intersector, glm::vec3(frame.view->eye()));
  return context;
}

}  // namespace sideray::rt
