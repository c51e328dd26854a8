#include "rules.h"

#include <cmath>
#include <string>

namespace {

// The engine blends what is shown, not light. A reflectance is raised to that space, so that a reflection over black
// looks as bright as it is; over bright surfaces it is then too bright, as all that such an engine adds.
float index_for(float reflectance) {
  const float root = std::sqrt(std::pow(reflectance, 1.0f / 2.2f));
  return (1.0f + root) / (1.0f - root);
}

}  // namespace

sideray_osg::Rules terrace_rules() {
  sideray_osg::Rules rules;
  rules.shadow_lights = {0};  // the sun; light 1 stands for the sky
  rules.adjust = [](const osg::StateSet& state, sideray_material_desc& d) {
    if (d.alpha_mode != SIDERAY_BLEND || d.blend_mode == SIDERAY_BLEND_ADDITIVE) return;
    // A pane is one quad for two surfaces of glass; all else shows each.
    const osg::StateAttribute* const material = state.getAttribute(osg::StateAttribute::MATERIAL);
    const bool is_pane = material && (material->getName() == "window glass" || material->getName() == "vitrine glass");
    d.ior = index_for(is_pane ? 0.08f : 0.03f);
    d.roughness = 0.05f;
    d.specular = 1.0f;
    for (float& c : d.specular_color) c = 1.0f;
  };
  return rules;
}
