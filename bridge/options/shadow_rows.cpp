// Options that say how opaque surfaces are lit, and which geometry rays hit.
#include "bridge/options/option_row.h"

namespace sideray::bridge {
namespace {

const char* unless_inexact(const OptionValues& v) {
  return v.shadows.method == SIDERAY_SHADOWS_INEXACT ? nullptr : "no shadow ray is inexact";
}

// Whether rays hit anything whose pose counts.
const char* unless_posed(const OptionValues& v) {
  if (v.is_exact()) return "a reference poses every instance as it is drawn";
  const bool traces = v.has_masks() || v.picture.reflections != 0 || v.is_raytraced() ||
                      (v.is_hybrid() && v.translucency.layers > 0);
  return traces ? nullptr : "nothing is traced";
}


OptionRow shadows_row() {
  OptionRow row = option_choice("shadows",
                                {{"map", SIDERAY_SHADOWS_MAP},
                                 {"exact", SIDERAY_SHADOWS_EXACT},
                                 {"inexact", SIDERAY_SHADOWS_INEXACT},
                                 {"off", SIDERAY_SHADOWS_OFF}},
                                "inexact", "how opaque pixels are shadowed");
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "exact";
  row.beside_reference = "off";
  row.store = [](OptionValues& v, const OptionValue& value) { v.shadows.method = value.as<sideray_shadows>(); };
  row.decided = [](const OptionValues& v, const std::string& text) {
    return v.is_reference && v.shadows.method != SIDERAY_SHADOWS_OFF ? std::string("exact") : text;
  };
  return row;
}

OptionRow of_inexact_shadows(OptionRow row) {
  row.option.applies = "shadows inexact";
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "";
  row.unread = unless_inexact;
  return row;
}

OptionRow inexact_row() {
  OptionRow row = of_inexact_shadows(option_choice("inexact",
                                                   {{"tmin", SIDERAY_INEXACT_TMIN},
                                                    {"bounded", SIDERAY_INEXACT_BOUNDED},
                                                    {"restpose", SIDERAY_INEXACT_RESTPOSE}},
                                                   "restpose", "which test inexact shadow rays take"));
  row.store = [](OptionValues& v, const OptionValue& value) { v.shadows.inexact = value.as<sideray_inexact>(); };
  return row;
}

OptionRow bias_row() {
  OptionRow row = of_inexact_shadows(option_number(
      "inexact-bias", "B", {0, 1e6}, "0.5", "inexact tmin: the world units over which shadow rays ignore hits, at most"));
  row.option.applies = "shadows inexact with inexact tmin";
  row.store = [](OptionValues& v, const OptionValue& value) { v.shadows.inexact_bias = value.real(); };
  row.idle = [](const OptionValues& v) {
    return v.shadows.inexact == SIDERAY_INEXACT_TMIN ? nullptr : "the inexact test has no bias of its own";
  };
  return row;
}

OptionRow target_row() {
  OptionRow row = of_inexact_shadows(option_choice(
      "inexact-target",
      {{"model", SIDERAY_TARGET_MODEL}, {"bit", SIDERAY_TARGET_BIT}, {"stencil", SIDERAY_TARGET_STENCIL}}, "stencil",
      "which surfaces take the inexact test"));
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.shadows.inexact_target = value.as<sideray_inexact_target>();
  };
  return row;
}

OptionRow of_poses(OptionRow row, const char* exact_value) {
  row.option.applies = "where rays are traced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = exact_value;
  row.beside_reference = "";
  row.idle = unless_posed;
  return row;
}

OptionRow foliage_row() {
  OptionRow row = of_poses(option_choice("foliage",
                                         {{"static", SIDERAY_FOLIAGE_STATIC},
                                          {"shared", SIDERAY_FOLIAGE_SHARED},
                                          {"unique", SIDERAY_FOLIAGE_UNIQUE}},
                                         "shared", "which poses of plants in wind rays hit"),
                           "unique");
  row.store = [](OptionValues& v, const OptionValue& value) { v.poses.foliage = value.as<sideray_foliage>(); };
  return row;
}

OptionRow copies_row() {
  OptionRow row = of_poses(
      option_integer("shared-copies", "K", {1, 256}, "1", "how many poses the instances of a mesh share"), "");
  row.option.applies = "foliage shared and unique";
  row.store = [](OptionValues& v, const OptionValue& value) { v.poses.shared_copies = value.whole(); };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = unless_posed(v)) return reason;
    return v.poses.foliage == SIDERAY_FOLIAGE_STATIC ? "rays hit the neutral pose" : nullptr;
  };
  return row;
}

OptionRow cap_row() {
  OptionRow row = of_poses(option_integer("unique-cap", "N|none", {1, 100000000}, "256",
                                          "how many instances of a mesh have a pose of their own, at most"),
                           "none");
  row.words = {{"none", 0}};
  row.option.applies = "foliage unique";
  row.store = [](OptionValues& v, const OptionValue& value) { v.poses.unique_cap = value.whole(); };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = unless_posed(v)) return reason;
    return v.poses.foliage == SIDERAY_FOLIAGE_UNIQUE ? nullptr : "no instance has a pose of its own";
  };
  return row;
}

OptionRow culling_row() {
  OptionRow row = of_poses(
      option_number("cull-angle", "DEG", {0, 90}, "1", "instances that appear under a smaller angle are not traced"),
      "0");
  row.store = [](OptionValues& v, const OptionValue& value) { v.poses.cull_angle_deg = value.real(); };
  return row;
}

OptionRow reflections_row() {
  OptionRow row = option_switch("reflections", "off", "what opaque surfaces reflect is traced");
  row.option.cost = SIDERAY_COST_PICTURE;
  row.store = [](OptionValues& v, const OptionValue& value) { v.picture.reflections = value.on(); };
  return row;
}

OptionRow occlusion_row() {
  OptionRow row = option_switch("ao", "off", "ambient occlusion of opaque surfaces is traced");
  row.option.cost = SIDERAY_COST_PICTURE;
  row.option.exact_value = "off";
  row.idle = [](const OptionValues& v) {
    return v.is_reference ? "the equations of a reference have no ambient occlusion" : nullptr;
  };
  row.store = [](OptionValues& v, const OptionValue& value) { v.picture.ao = value.on(); };
  return row;
}

OptionRow denoise_row() {
  OptionRow row = option_switch("denoise", "on", "shadows, occlusion and what rough layers reflect are filtered");
  row.option.applies = "where shadows, occlusion or layers are traced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "off";
  row.beside_reference = "off";
  row.unread = [](const OptionValues& v) {
    return v.has_masks() || v.is_hybrid() ? nullptr : "nothing that is traced is filtered";
  };
  row.store = [](OptionValues& v, const OptionValue& value) { v.filters_results = value.on(); };
  return row;
}

OptionRow denoise_on_row() {
  OptionRow row =
      option_choice("denoise-on",
                    {{"auto", SIDERAY_DENOISE_AUTO}, {"cpu", SIDERAY_DENOISE_CPU}, {"gpu", SIDERAY_DENOISE_GPU}}, "auto",
                    "where shadows and occlusion are filtered");
  row.option.applies = "where shadows or occlusion are traced and filtered";
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "";
  row.unread = [](const OptionValues& v) {
    return v.has_masks() ? nullptr : "neither shadows nor occlusion are traced";
  };
  row.idle = [](const OptionValues& v) { return v.filters_results ? nullptr : "nothing is filtered"; };
  row.store = [](OptionValues& v, const OptionValue& value) { v.filters.masks_on = value.as<sideray_denoise_on>(); };
  return row;
}

}  // namespace

std::vector<OptionRow> shadow_rows() {
  return {shadows_row(), inexact_row(), bias_row(),        target_row(),    foliage_row(), copies_row(),
          cap_row(),     culling_row(), reflections_row(), occlusion_row(), denoise_row(), denoise_on_row()};
}

}  // namespace sideray::bridge
