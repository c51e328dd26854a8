#include "rules.h"

#include <cmath>
#include <string>

namespace {

// The engine blends displayed values, not light, so reflectances are converted. Over black the power 1/2.2 is right;
// over all brightnesses alike 0.8 fits best.
constexpr float over_black = 1.0f / 2.2f, over_anything = 0.8f;

float index_for(float reflectance, float power) {
  const float root = std::sqrt(std::pow(reflectance, power));
  return (1.0f + root) / (1.0f - root);
}

}  // namespace

sideray_osg::Rules terrace_rules() {
  sideray_osg::Rules rules;
  rules.shadow_lights = {0};  // the sun; light 1 stands for the sky
  rules.adjust = [](const osg::StateSet& state, sideray_material_desc& d) {
    if (d.alpha_mode != SIDERAY_BLEND || d.blend_mode == SIDERAY_BLEND_ADDITIVE) return;
    // A pane is one quad for two surfaces of glass; other glass has a quad for each.
    const osg::StateAttribute* const material = state.getAttribute(osg::StateAttribute::MATERIAL);
    const bool is_pane = material && (material->getName() == "window glass" || material->getName() == "vitrine glass");
    d.ior = is_pane ? index_for(0.08f, over_black) : index_for(0.03f, over_anything);  // rooms behind panes are dark
    d.roughness = 0.05f;
    d.specular = 1.0f;
    for (float& c : d.specular_color) c = 1.0f;
  };
  return rules;
}
