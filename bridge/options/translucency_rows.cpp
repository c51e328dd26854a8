// Defines options for translucent surfaces.
#include <sideray/diagnostics.h>

#include "bridge/base/reuse.h"
#include "bridge/base/whole_pixels.h"
#include "bridge/options/option_row.h"
#include "model/failure.h"
#include "rt/layers/layer_request.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t hybrid_layers = 4, raytraced_surfaces = 2;  // used where the option is not set
constexpr int unlimited = 0, by_the_plan = -1;
constexpr int most_cached = rt::most_cached_layers, most_composited = rt::most_composited_layers;

const char* unless_layered(const OptionValues& v) {
  return v.is_hybrid() ? nullptr : "only hybrid translucency has layers";
}

const char* unless_traced(const OptionValues& v) {
  return v.is_hybrid() || v.is_raytraced() ? nullptr : "neither layers nor surfaces along rays are traced";
}

const char* unless_blended(const OptionValues& v) {
  return v.is_hybrid() || v.draws(SIDERAY_TRANSLUCENCY_RASTER) ? nullptr : "no fragments are blended";
}

const char* without_layers(const OptionValues& v) {
  return v.is_hybrid() && v.translucency.layers == 0 ? "hybrid translucency without layers is raster" : nullptr;
}

// Returns whether fragments look up layers at all.
bool fills_cache(const OptionValues& v, const OptionScene& scene) {
  return v.is_hybrid() && v.translucency.layers > 0 && scene.facts.layered_objects > 0;
}

// Returns whether rays pass translucent surfaces with shortcuts.
bool steps(const OptionValues& v, const OptionScene& scene) {
  return scene.has_translucency() && (fills_cache(v, scene) || v.is_raytraced());
}

// Returns whether every masked pixel is traced.
bool is_full(const OptionValues& v) {
  return v.translucency.cache_rate == SIDERAY_RATE_FULL;
}

void add_methods(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  const std::vector<sideray_option_value> layers{{"translucency", "hybrid"}, {"layers", "8"}, {"ray-traced", "all"}};
  if (!scene.has_translucency()) {
    list.push_back({"translucency", false,
                    "the scene has no translucent surface: no layers, order, match or rate to lose by"});
  } else if (v.is_exact()) {
    list.push_back({"translucency", false, "translucent surfaces are shaded as in the reference"});
  } else if (v.draws(SIDERAY_TRANSLUCENCY_OFF)) {
    list.push_back({"off", true,
                    "translucent surfaces are not drawn; instead from 8 ray-traced layers in exact order", layers});
    list.back().exactly.push_back({"oit", "peel"});
  } else if (!v.is_raytraced() && !fills_cache(v, scene)) {
    const bool can = scene.facts.traceable_objects > 0;
    list.push_back({"raster", can,
                    can ? "translucent surfaces shaded by the rasterizer; instead from 8 ray-traced layers"
                        : "no translucent object can have layers",
                    can ? layers : std::vector<sideray_option_value>{}});
  }
}

OptionRow method_row() {
  OptionRow row = option_choice("translucency",
                                {{"raster", SIDERAY_TRANSLUCENCY_RASTER},
                                 {"raytraced", SIDERAY_TRANSLUCENCY_RAYTRACED},
                                 {"hybrid", SIDERAY_TRANSLUCENCY_HYBRID},
                                 {"reference", SIDERAY_TRANSLUCENCY_REFERENCE},
                                 {"off", SIDERAY_TRANSLUCENCY_OFF}},
                                "hybrid", "how translucent surfaces are drawn");
  row.option.group = most_used;
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "reference";
  row.beside_reference = "";
  bind<&OptionValues::translucency, &sideray_translucency_options::method>(row);
  row.decided = [](const OptionValues& v, const std::string& text) {
    return v.is_reference ? std::string("reference") : text;
  };
  row.shortcuts = add_methods;
  row.settled = [](const OptionValues& v, const OptionScene& scene, const std::string& text) -> std::string {
    return v.is_hybrid() && !fills_cache(v, scene) ? "raster" : text;
  };
  return row;
}

OptionRow ray_traced_row() {
  OptionRow row = option_text("ray-traced", "auto|all|none|GLOB,...|largest:K", "auto",
                              "hybrid: which objects have ray-traced layers");
  row.option.applies = "hybrid";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "all";
  row.beside_reference = "";
  row.unread = unless_layered;
  row.idle = without_layers;
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (!fills_cache(v, scene)) return;
    const uint64_t with = scene.facts.layered_objects, all = scene.facts.traceable_objects;
    if (with >= all)
      list.push_back({"objects", false, "every translucent object that can have layers has them"});
    else
      list.push_back({"objects", true,
                      fmt::format("{} of {} translucent objects that could have layers have none; instead all have",
                                  all - with, all),
                      {{"ray-traced", "all"}}});
  };
  return row;
}

// Checks the number of surfaces against the method's range. In the struct, 0 means unlimited, but 0 layers if the
// method is hybrid.
void check_layers(const OptionValues& v, const OptionValue& value) {
  if (!v.is_hybrid() && !v.is_raytraced()) return;
  const int least = v.is_hybrid() ? 0 : 1, most = v.is_hybrid() ? most_cached : most_composited;
  const int word = v.is_hybrid() ? by_the_plan : unlimited;
  if (value.is_word && static_cast<int>(value.number) == word) return;
  if (value.is_word && value.text != "0")
    fail(SIDERAY_INVALID_ARGUMENT, "layers: \"{}\" is not a whole number; give {} to {}", value.text, least, most);
  if (value.number < least || value.number > most)
    fail(SIDERAY_INVALID_ARGUMENT, "layers: {} is out of range; give {} to {}", value.text, least, most);
}

void add_layers(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  const uint32_t layers = v.translucency.layers;
  if (!steps(v, scene)) return;
  if (v.is_raytraced() && layers == unlimited)
    list.push_back({"layers", false, "rays go to the last surface"});
  else if (v.is_raytraced())
    list.push_back({"layers", true, fmt::format("rays end behind {} surfaces; instead behind the last one", layers),
                    {{"layers", "unlimited"}}});
  else if (layers >= rt::most_cached_layers)
    list.push_back({"layers", false, "8 is as many as a cache holds; what lies deeper is in residual.cache"});
  else
    list.push_back(
        {"layers", true,
         fmt::format("surfaces behind the first {} of a pixel keep raster shading; instead behind 8", layers),
         {{"layers", "8"}}});
}

// Returns whether rays are followed from surface to surface, because something refracts them.
bool follows_refraction(const OptionValues& v, const OptionScene& scene) {
  return v.is_raytraced() && v.translucency.refraction && scene.facts.bending_objects > 0;
}

// Limits the number to what a ray can hit. Not possible with refraction or sprites, which add to the surfaces.
std::string settled_layers(const OptionValues& v, const OptionScene& scene, const std::string& text) {
  const bool is_raytraced = v.is_raytraced();
  const sideray_translucency_options& o = v.translucency;
  if (is_raytraced && (follows_refraction(v, scene) || (o.particles && scene.facts.sprites > 0))) return text;
  const uint64_t most = is_raytraced ? scene.facts.most_surfaces : scene.facts.most_layers;
  const bool holds_all = most > 0 && ((is_raytraced && o.layers == unlimited) || o.layers > most);
  return holds_all && most != SIDERAY_UNBOUNDED ? std::to_string(most) : text;
}

OptionRow layers_row() {
  OptionRow row = option_integer("layers", "N|auto|unlimited", {0, most_composited}, "",
                                 "traced surfaces of a pixel [hybrid: auto, raytraced: 2]");
  row.option.group = most_used;
  row.words = {{"auto", by_the_plan}, {"unlimited", unlimited}};
  row.range = "0 to 8 or auto where translucency is hybrid, 1 to 64 or unlimited where it is raytraced";
  row.option.applies = "hybrid and raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "8";
  row.beside_reference = "";
  row.unread = unless_traced;
  row.check = check_layers;
  row.checks_structs = true;
  row.shortcuts = add_layers;
  row.settled = settled_layers;
  row.store = [](OptionValues& v, const OptionValue& value) {
    const bool is_default = value.is_word && static_cast<int>(value.number) == by_the_plan;
    v.surfaces = is_default ? std::nullopt : std::optional(value.whole());
  };
  row.load = [](const OptionValues& v) { return static_cast<double>(v.translucency.layers); };
  row.decided = [](const OptionValues& v, const std::string&) -> std::string {
    if (!v.is_hybrid() && !v.is_raytraced()) return "";
    return v.is_raytraced() && v.translucency.layers == unlimited ? "unlimited" : std::to_string(v.translucency.layers);
  };
  return row;
}

// Returns whether options let layers reuse the rays of donors.
bool reuses_rays(const OptionValues& v) {
  const sideray_translucency_options& o = v.translucency;
  return o.ray_reuse != 0.0f && !(is_auto_reuse(o) && why_no_ray_reuse(use_of(v)));
}

void check_reuse(const OptionValues& v, const OptionValue& value) {
  if (value.number <= 0 || v.is_reference) return;
  if (const char* reason = why_no_ray_reuse(use_of(v)))
    fail(SIDERAY_INVALID_ARGUMENT, "ray-reuse: {}; leave one of the two out, or give auto or 0", reason);
}

void add_reuse(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  if (!steps(v, scene)) return;
  if (!reuses_rays(v))
    return list.push_back({"ray-reuse", false, "every layer traces its own rays"});
  list.push_back({"ray-reuse", true,
                  "three of four pixels reuse the rays of their neighbours; instead all are traced",
                  {{"ray-reuse", "0"}}});
}

OptionRow reuse_row() {
  OptionRow row = option_number("ray-reuse", "E|auto", {0, 1e6}, "auto",
                                "largest spread among donors before a pixel traces its own rays");
  row.words = {{"auto", static_cast<int>(SIDERAY_RAY_REUSE_AUTO)}};
  row.range = "0 to 1e+06, or auto";
  row.option.applies = "hybrid and raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "0";
  row.beside_reference = "";
  row.unread = unless_traced;
  row.idle = without_layers;
  row.check = check_reuse;
  row.checks_structs = true;
  row.shortcuts = add_reuse;
  row.decided = [](const OptionValues& v, const std::string& text) {
    return is_auto_reuse(v.translucency) && !reuses_rays(v) ? std::string("0") : text;
  };
  bind<&OptionValues::translucency, &sideray_translucency_options::ray_reuse>(row);
  return row;
}

// Completes a row that belongs to the layer cache.
OptionRow of_the_cache(OptionRow row, const char* exact_value) {
  row.option.applies = "hybrid";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = exact_value;
  row.beside_reference = "";
  row.unread = unless_layered;
  row.idle = without_layers;
  return row;
}

OptionRow rate_row() {
  OptionRow row = of_the_cache(option_choice("cache-rate",
                                             {{"full", SIDERAY_RATE_FULL},
                                              {"checkerboard", SIDERAY_RATE_CHECKERBOARD},
                                              {"interleaved", SIDERAY_RATE_INTERLEAVED},
                                              {"quarter", SIDERAY_RATE_QUARTER}},
                                             "full", "hybrid: which of the masked pixels are traced"),
                               "full");
  bind<&OptionValues::translucency, &sideray_translucency_options::cache_rate>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (!fills_cache(v, scene)) return;
    if (!is_full(v))
      list.push_back({"rate", true, "some pixels take their neighbours' layers; instead every masked pixel is traced",
                      {{"cache-rate", "full"}}});
    else
      list.push_back({"rate", false, "every masked pixel is traced"});
  };
  return row;
}

OptionRow second_wave_row() {
  OptionRow row = of_the_cache(
      option_switch("second-wave", "on", "hybrid: pixels whose neighbours have no layer for them are traced"),
      "on");
  row.option.diagnostic = 1;
  bind<&OptionValues::translucency, &sideray_translucency_options::second_wave>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (fills_cache(v, scene) && !is_full(v) && !v.translucency.second_wave)
      list.push_back({"second-wave", true,
                      "pixels without such a neighbour keep raster shading; instead they are traced",
                      {{"second-wave", "on"}}});
  };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = without_layers(v)) return reason;
    return is_full(v) ? "every masked pixel is traced in the first wave" : nullptr;
  };
  return row;
}

const char* why_none_is_whole(const OptionValues& v) {
  if (const char* reason = without_layers(v)) return reason;
  return no_whole_pixels(v.translucency, false).reason;
}

void check_whole(const OptionValues& v, const OptionValue& value) {
  if (!value.on() || v.is_reference || !v.is_hybrid() || without_layers(v)) return;
  if (const NoWholePixels none = no_whole_pixels(v.translucency, false); none.reason)
    fail(SIDERAY_INVALID_ARGUMENT, "whole-pixels on: {}; leave '{}' out or give another, or leave 'whole-pixels' out",
         none.reason, none.option);
}

OptionRow whole_row() {
  OptionRow row = of_the_cache(
      option_switch("whole-pixels", "on", "hybrid: pixels with all surfaces in layers are drawn at once"), "on");
  row.option.diagnostic = 1;
  bind<&OptionValues::translucency, &sideray_translucency_options::whole_pixels>(row);
  row.idle = why_none_is_whole;
  row.check = check_whole;
  return row;
}

OptionRow match_row() {
  OptionRow row = of_the_cache(
      option_choice("match",
                    {{"id", SIDERAY_MATCH_ID}, {"nearest", SIDERAY_MATCH_NEAREST}, {"distance", SIDERAY_MATCH_DISTANCE}},
                    "id", "hybrid: how a fragment finds its layer"),
      "id");
  row.option.diagnostic = 1;
  bind<&OptionValues::translucency, &sideray_translucency_options::match>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (fills_cache(v, scene) && v.translucency.match != SIDERAY_MATCH_ID)
      list.push_back({"match", true, "fragments find their layers by distance; instead by surface id", {{"match", "id"}}});
  };
  return row;
}

OptionRow match_threshold_row() {
  OptionRow row = of_the_cache(option_number("match-threshold", "T", {1e-9, 1.0}, "0.001",
                                             "match distance: largest relative difference of distances"),
                               "");
  row.option.diagnostic = 1;
  row.option.applies = "hybrid with match distance";
  bind<&OptionValues::translucency, &sideray_translucency_options::match_threshold>(row);
  row.idle = [](const OptionValues& v) {
    if (const char* reason = without_layers(v)) return reason;
    return v.translucency.match == SIDERAY_MATCH_DISTANCE ? nullptr : "layers are not matched by distance alone";
  };
  return row;
}

// Completes a row that belongs to rays through translucent surfaces.
OptionRow of_the_rays(OptionRow row, const char* exact_value) {
  row.option.applies = "hybrid and raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = exact_value;
  row.beside_reference = "";
  row.unread = unless_traced;
  row.idle = without_layers;
  return row;
}

OptionRow step_row() {
  OptionRow row = of_the_rays(option_choice("step",
                                            {{"multihit", SIDERAY_STEP_MULTIHIT},
                                             {"retrace", SIDERAY_STEP_RETRACE},
                                             {"listing", SIDERAY_STEP_LISTING}},
                                            "multihit", "how a ray finds its surfaces one after another"),
                              "multihit");
  row.option.diagnostic = 1;
  bind<&OptionValues::translucency, &sideray_translucency_options::step>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (!steps(v, scene)) return;
    if (v.translucency.step == SIDERAY_STEP_LISTING)
      list.push_back({"step", true, "rays step as listing 50-1; instead they hit every surface", {{"step", "multihit"}}});
    else
      list.push_back({"step", false, "rays hit every surface once"});
  };
  row.settled = [](const OptionValues& v, const OptionScene& scene, const std::string& text) {
    return follows_refraction(v, scene) ? std::string() : text;
  };
  return row;
}

OptionRow mask_row() {
  OptionRow row = of_the_rays(
      option_choice("mask", {{"none", SIDERAY_NO_MASK}, {"stencil", SIDERAY_STENCIL_MASK}, {"count", SIDERAY_COUNT_MASK}},
                    "count", "which pixels are traced"),
      "none");
  row.option.advanced = 1;
  bind<&OptionValues::translucency, &sideray_translucency_options::mask>(row);
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (!steps(v, scene)) return;
    if (v.translucency.mask != SIDERAY_NO_MASK)
      list.push_back({"mask", true, "rays start where the rasterizer marked pixels; instead in every pixel",
                      {{"mask", "none"}}});
    else
      list.push_back({"mask", false, "rays start in every pixel"});
  };
  return row;
}

OptionRow refraction_row() {
  OptionRow row = option_switch("refraction", "on", "solids and rough glass bend and blur what is behind them");
  row.option.applies = "all translucency";
  row.option.cost = SIDERAY_COST_PICTURE;
  row.unread = [](const OptionValues& v) {
    return v.draws(SIDERAY_TRANSLUCENCY_OFF) && !v.is_exact() ? "nothing translucent is drawn" : nullptr;
  };
  row.settled = [](const OptionValues&, const OptionScene& scene, const std::string& text) {
    return scene.facts.bending_objects > 0 ? text : std::string();
  };
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.refraction = value.on();
    v.reference.refraction = value.on();
  };
  return row;
}

OptionRow particles_row() {
  OptionRow row = option_switch("rt-particles", "off", "raytraced: rays hit particles");
  row.option.diagnostic = 1;
  row.option.applies = "raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "on";
  row.beside_reference = "";
  row.unread = [](const OptionValues& v) {
    return v.is_raytraced() ? nullptr : "only raytraced translucency leaves particles to rays";
  };
  bind<&OptionValues::translucency, &sideray_translucency_options::particles>(row);
  row.settled = [](const OptionValues&, const OptionScene& scene, const std::string& text) -> std::string {
    return scene.facts.sprites > 0 ? text : "";
  };
  row.shortcuts = [](const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
    if (v.is_raytraced() && scene.facts.sprites > 0 && !v.translucency.particles)
      list.push_back({"particles", true, "particles are left out; instead rays hit them as quads", {{"rt-particles", "on"}}});
  };
  return row;
}

void add_orders(const OptionValues& v, const OptionScene& scene, std::vector<Shortcut>& list) {
  if (!scene.has_translucency() || v.is_exact() || v.draws(SIDERAY_TRANSLUCENCY_OFF)) return;
  if (v.is_raytraced())
    list.push_back({"order", false, "rays hit surfaces in their order"});
  else if (v.translucency.oit == SIDERAY_OIT_ABUFFER || v.translucency.oit == SIDERAY_OIT_PEEL)
    list.push_back({"order", false, "every fragment is in its place already"});
  else
    list.push_back({"order", true,
                    "fragments blended in an order that is not that of each pixel; instead peeled, to the last one",
                    {{"oit", "peel"}}});
}

OptionRow order_row() {
  OptionRow row = option_choice("oit",
                                {{"sorted", SIDERAY_OIT_SORTED},
                                 {"abuffer", SIDERAY_OIT_ABUFFER},
                                 {"peel", SIDERAY_OIT_PEEL}},
                                "sorted", "the order in which translucent fragments are blended");
  row.option.applies = "raster and hybrid";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "peel";
  row.beside_reference = "";
  row.unread = unless_blended;
  row.shortcuts = add_orders;
  bind<&OptionValues::translucency, &sideray_translucency_options::oit>(row);
  return row;
}

}  // namespace

std::vector<OptionRow> translucency_rows() {
  std::vector<OptionRow> rows{method_row(),      ray_traced_row(), layers_row(),    reuse_row(),           rate_row(),
                              second_wave_row(), whole_row(),      match_row(),     match_threshold_row(), step_row(),
                              mask_row(),        refraction_row(), particles_row(), order_row()};
  for (OptionRow& row : rows) row.option.part = "translucency";
  return under_title("Translucency", std::move(rows));
}

uint32_t default_surfaces(const OptionValues& v) {
  switch (v.translucency.method) {
    case SIDERAY_TRANSLUCENCY_RAYTRACED:
      return raytraced_surfaces;
    case SIDERAY_TRANSLUCENCY_HYBRID:
      return hybrid_layers;
    default:
      return 0;
  }
}

}  // namespace sideray::bridge
