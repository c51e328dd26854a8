#include "gl/passes/pass_inputs.h"

namespace sideray::gl {

// Two-sided foliage is what the model says leaves are: cut out of cards that are seen from both sides.
bool takes_inexact(const model::Material& material, uint32_t wind, sideray_inexact_target target) {
  if (material.translucent) return false;
  if (target == SIDERAY_TARGET_MODEL)
    return material.desc.double_sided &&
           (material.desc.alpha_mode == SIDERAY_MASK || material.desc.diffuse_transmission > 0.0f);
  return material.desc.inexact_shadow || wind != 0;
}

}  // namespace sideray::gl
