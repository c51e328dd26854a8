// Defines options for the light on opaque surfaces, and for the geometry that rays hit.
#include <fmt/format.h>
#include <sideray/diagnostics.h>

#include "bridge/options/option_row.h"

namespace sideray::bridge {
namespace {

const char* unless_inexact(const OptionValues& v) {
  return v.shadows.method == SIDERAY_SHADOWS_INEXACT ? nullptr : "no shadow ray is inexact";
}

// Returns why poses do not matter; null where rays may hit a posed instance.
const char* unless_posed(const OptionValues& v) {
  if (v.is_exact()) return "a reference poses every instance as it is drawn";
  const bool traces = v.has_masks() || v.picture.reflections != 0 || v.is_raytraced() ||
                      (v.is_hybrid() && v.translucency.layers > 0);
  return traces ? nullptr : "nothing is traced";
}


void add_shadows(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  const sideray_shadow_options& o = v.shadows;
  if (o.method == SIDERAY_SHADOWS_OFF)
    list.push_back({"bias", false, "no shadows, in the reference neither"});
  else if (o.method == SIDERAY_SHADOWS_MAP)
    list.push_back({"shadow-maps", true, "shadows of opaque surfaces from maps; instead by rays", {{"shadows", "exact"}}});
  else if (o.method == SIDERAY_SHADOWS_EXACT)
    list.push_back({"bias", false, "shadow rays are exact"});
  else if (scene.facts.inexact_objects[o.inexact_target] == 0)
    list.push_back({"bias", false, "nothing in the scene takes the inexact shadow test"});
  else
    list.push_back({"bias", true, "shadow rays of marked surfaces take the inexact test; instead all are exact",
                    {{"shadows", "exact"}}});
}

OptionRow shadows_row() {
  OptionRow row = option_choice("shadows",
                                {{"map", SIDERAY_SHADOWS_MAP},
                                 {"exact", SIDERAY_SHADOWS_EXACT},
                                 {"inexact", SIDERAY_SHADOWS_INEXACT},
                                 {"off", SIDERAY_SHADOWS_OFF}},
                                "inexact", "how opaque surfaces are shadowed");
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.part = "shadows";
  row.option.exact_value = "exact";
  row.beside_reference = "off";
  row.shortcuts = add_shadows;
  row.settled = [](const OptionValues& v, const OptionScene& scene, const std::string& text) -> std::string {
    const bool is_exact = scene.facts.inexact_objects[v.shadows.inexact_target] == 0;
    return v.shadows.method == SIDERAY_SHADOWS_INEXACT && is_exact ? "exact" : text;
  };
  bind<&OptionValues::shadows, &sideray_shadow_options::method>(row);
  row.decided = [](const OptionValues& v, const std::string& text) {
    return v.is_reference && v.shadows.method != SIDERAY_SHADOWS_OFF ? std::string("exact") : text;
  };
  return row;
}

OptionRow of_inexact_shadows(OptionRow row) {
  row.option.part = "shadows";
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
                                                   "restpose", "test of inexact shadow rays"));
  row.option.advanced = 1;
  bind<&OptionValues::shadows, &sideray_shadow_options::inexact>(row);
  row.in_structs = {SIDERAY_EXACT, SIDERAY_INEXACT_ORIGIN};
  return row;
}

OptionRow bias_row() {
  OptionRow row = of_inexact_shadows(option_number(
      "inexact-bias", "B", {0, 1e6}, "0.5", "inexact tmin: largest distance over which hits are ignored"));
  row.option.diagnostic = 1;
  row.option.applies = "shadows inexact with inexact tmin";
  bind<&OptionValues::shadows, &sideray_shadow_options::inexact_bias>(row);
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
  row.option.diagnostic = 1;
  bind<&OptionValues::shadows, &sideray_shadow_options::inexact_target>(row);
  return row;
}

OptionRow of_poses(OptionRow row, const char* exact_value) {
  row.option.part = "poses";
  row.option.applies = "where rays are traced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = exact_value;
  row.beside_reference = "";
  row.idle = unless_posed;
  return row;
}

void add_poses(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  if (scene.facts.swaying_objects == 0)
    list.push_back({"pose", false, "nothing is moved by wind"});
  else if (v.is_exact() || v.poses.poses == SIDERAY_POSES_ALL)
    list.push_back({"pose", false, "rays hit every instance in its own pose"});
  else
    list.push_back({"pose", true, "rays hit plants in a pose that is not that of each instance; instead in its own",
                    {{"poses", "all"}}});
}

OptionRow poses_row() {
  OptionRow row = of_poses(option_integer("poses", "rest|K|all", {1, 256}, "16",
                                          "poses in which rays hit plants: neutral, K a mesh, or all"),
                           "all");
  row.words = {{"rest", SIDERAY_POSES_REST}, {"all", SIDERAY_POSES_ALL}};
  row.range = "rest, 1 to 256, or all";
  row.shortcuts = add_poses;
  bind<&OptionValues::poses, &sideray_pose_options::poses>(row);
  return row;
}

OptionRow culling_row() {
  OptionRow row = of_poses(
      option_number("cull-angle", "DEG", {0, 90}, "0", "instances of a smaller angular size are not traced"),
      "0");
  row.option.advanced = 1;
  bind<&OptionValues::poses, &sideray_pose_options::cull_angle_deg>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene&, std::vector<Shortcut>& list) {
    const float angle = v.poses.cull_angle_deg;
    if (angle > 0 && !v.is_exact())
      list.push_back({"culling", true,
                      fmt::format("rays do not hit what appears under {} degrees; instead they hit everything", angle),
                      {{"cull-angle", "0"}}});
    else
      list.push_back({"culling", false, "rays hit everything, however small it looks"});
  };
  return row;
}

// Returns whether ambient occlusion, or reflections of opaque surfaces, are traced in such a scene.
bool traces_ao(const OptionValues& v, const OptionScene& scene) {
  if (v.is_reference || v.picture.ambient == SIDERAY_AMBIENT_OFF) return false;
  return v.picture.ambient != SIDERAY_AMBIENT_AUTO || scene.facts.auto_ao;
}

bool traces_bounces(const OptionValues& v, const OptionScene& scene) {
  if (v.is_reference) return false;
  if (v.picture.ambient == SIDERAY_AMBIENT_AUTO) return scene.facts.auto_bounce != 0;
  return v.picture.ambient == SIDERAY_AMBIENT_BOUNCE;
}

bool traces_reflections(const OptionValues& v, const OptionScene& scene) {
  if (v.picture.reflections != SIDERAY_REFLECTIONS_AUTO) return v.picture.reflections != 0;
  return !v.is_reference && scene.facts.auto_reflections;
}

// Makes a row for rays that start at opaque surfaces. `automatic` is the struct's value of auto.
OptionRow opaque_rays_row(const char* name, int automatic, const char* help) {
  return option_choice(name, {{"auto", automatic}, {"on", 1}, {"off", 0}}, "auto", help);
}

// Returns the value in effect: a reference has nothing to choose and turns `auto` off.
std::string decided_opaque(const OptionValues& v, const std::string& text) {
  return v.is_reference && text == "auto" ? "off" : text;
}

OptionRow reflections_row() {
  OptionRow row = opaque_rays_row("reflections", SIDERAY_REFLECTIONS_AUTO,
                                  "traced reflections of opaque surfaces; auto: if one is smooth");
  row.option.cost = SIDERAY_COST_PICTURE;
  bind<&OptionValues::picture, &sideray_render_options::reflections>(row);
  row.decided = decided_opaque;
  row.settled = [](const OptionValues& v, const OptionScene& scene, const std::string& text) -> std::string {
    if (!scene.facts.glossy_objects) return "";
    return text == "auto" ? (traces_reflections(v, scene) ? "on" : "off") : text;
  };
  return row;
}

const char* ambient_used(const OptionValues& v, const OptionScene& scene) {
  if (traces_bounces(v, scene)) return "bounce";
  return traces_ao(v, scene) && scene.facts.has_environment ? "ao" : "off";
}

OptionRow ambient_row() {
  OptionRow row = option_choice("ambient",
                                {{"auto", SIDERAY_AMBIENT_AUTO},
                                 {"off", SIDERAY_AMBIENT_OFF},
                                 {"ao", SIDERAY_AMBIENT_AO},
                                 {"bounce", SIDERAY_AMBIENT_BOUNCE}},
                                "auto", "the sky's light: all, its open share, or with light that bounces");
  row.option.cost = SIDERAY_COST_PICTURE;
  row.option.exact_value = "off";
  row.idle = [](const OptionValues& v) {
    return v.is_reference ? "the equations of a reference hold all light there is" : nullptr;
  };
  bind<&OptionValues::picture, &sideray_render_options::ambient>(row);
  row.decided = decided_opaque;
  row.settled = [](const OptionValues& v, const OptionScene& scene, const std::string&) -> std::string {
    return ambient_used(v, scene);
  };
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (traces_bounces(v, scene))
      list.push_back({"ambient", true, "light that bounces, which a reference of one bounce has not; instead none", {{"ambient", "off"}}});
    else if (traces_ao(v, scene))
      list.push_back({"ambient", true, "ambient occlusion, which a reference of one bounce has not; instead none", {{"ambient", "off"}}});
  };
  return row;
}

void add_noise(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  const bool has_layers = v.is_hybrid() && v.translucency.layers > 0 && scene.facts.layered_objects > 0;
  const bool has_masks = v.traces_shadows() || traces_ao(v, scene) || traces_bounces(v, scene);
  if (!has_masks && !traces_reflections(v, scene) && !has_layers && !v.is_raytraced())
    list.push_back({"denoise", false, "nothing is random: no rays"});
  else if (v.picture.denoise)
    list.push_back({"denoise", true,
                    "one random direction a ray, filtered; instead not filtered, the mean of many pictures",
                    {{"denoise", "off"}}, true});
  else
    list.push_back({"noise", true, "one random direction a ray; instead the mean of many pictures", {}, true});
}

OptionRow denoise_row() {
  OptionRow row = option_switch("denoise", "on", "filters traced shadows, occlusion and rough reflections");
  row.option.applies = "where shadows, occlusion or layers are traced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "off";
  row.beside_reference = "off";
  row.unread = [](const OptionValues& v) {
    return v.has_masks() || v.is_hybrid() ? nullptr : "nothing that is traced is filtered";
  };
  row.shortcuts = add_noise;
  row.past = [](const OptionValues& v) {
    return v.picture.denoise && v.has_masks() ? SIDERAY_PAST_AVERAGED : SIDERAY_PAST_NONE;
  };
  bind<&OptionValues::picture, &sideray_render_options::denoise>(row);
  return row;
}

}  // namespace

std::vector<OptionRow> shadow_rows() {
  return under_title("Light and what rays hit", {shadows_row(), inexact_row(), bias_row(), target_row(), poses_row(),
                                                 culling_row(), reflections_row(), ambient_row(), denoise_row()});
}

}  // namespace sideray::bridge
