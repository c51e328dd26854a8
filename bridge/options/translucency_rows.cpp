// Options that say how translucent surfaces are drawn.
#include <sideray/diagnostics.h>

#include "bridge/options/option_row.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t hybrid_layers = 4, raytraced_surfaces = 2;  // where the option says nothing
constexpr int unlimited = 0, by_the_plan = -1;

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

bool is_sparse(sideray_cache_rate rate) {
  return rate == SIDERAY_RATE_CHECKERBOARD || rate == SIDERAY_RATE_INTERLEAVED || rate == SIDERAY_RATE_QUARTER;
}

OptionRow method_row() {
  OptionRow row = option_choice("translucency",
                                {{"raster", SIDERAY_TRANSLUCENCY_RASTER},
                                 {"raytraced", SIDERAY_TRANSLUCENCY_RAYTRACED},
                                 {"hybrid", SIDERAY_TRANSLUCENCY_HYBRID},
                                 {"reference", SIDERAY_TRANSLUCENCY_REFERENCE},
                                 {"off", SIDERAY_TRANSLUCENCY_OFF}},
                                "hybrid", "how translucent surfaces are drawn");
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "reference";
  row.beside_reference = "";
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.method = value.as<sideray_translucency>();
  };
  row.decided = [](const OptionValues& v, const std::string& text) {
    return v.is_reference ? std::string("reference") : text;
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
  return row;
}

// Surfaces of a ray by what the method accepts.
void check_layers(const OptionValues& v, const OptionValue& value) {
  if (!v.is_hybrid() && !v.is_raytraced()) return;
  const int least = v.is_hybrid() ? 0 : 1, most = v.is_hybrid() ? 8 : 64;
  const int word = v.is_hybrid() ? by_the_plan : unlimited;
  if (value.is_word && static_cast<int>(value.number) == word) return;
  if (value.is_word)
    fail(SIDERAY_INVALID_ARGUMENT, "layers: \"{}\" is not a whole number; give {} to {}", value.text, least, most);
  if (value.number < least || value.number > most)
    fail(SIDERAY_INVALID_ARGUMENT, "layers: {} is out of range; give {} to {}", value.text, least, most);
}

OptionRow layers_row() {
  OptionRow row = option_integer("layers", "N|auto|unlimited", {0, 64}, "",
                                 "how many surfaces of a pixel are ray traced; hybrid: 0 to 8 [auto]; raytraced: 1 to "
                                 "64 or unlimited [2]");
  row.words = {{"auto", by_the_plan}, {"unlimited", unlimited}};
  row.range = "0 to 8 or auto where translucency is hybrid, 1 to 64 or unlimited where it is raytraced";
  row.option.applies = "hybrid and raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "8";
  row.beside_reference = "";
  row.unread = unless_traced;
  row.check = check_layers;
  row.store = [](OptionValues& v, const OptionValue& value) {
    const bool is_default = value.is_word && static_cast<int>(value.number) == by_the_plan;
    v.surfaces = is_default ? std::nullopt : std::optional(value.whole());
  };
  row.decided = [](const OptionValues& v, const std::string&) -> std::string {
    if (!v.is_hybrid() && !v.is_raytraced()) return "";
    return v.is_raytraced() && v.translucency.layers == unlimited ? "unlimited" : std::to_string(v.translucency.layers);
  };
  return row;
}

void check_threshold(const OptionValues& v, const OptionValue& value) {
  if (value.number == 0 || v.is_reference) return;
  const sideray_oit order = v.translucency.oit;
  if (v.is_hybrid() && (order == SIDERAY_OIT_WEIGHTED || order == SIDERAY_OIT_FRONT))
    fail(SIDERAY_INVALID_ARGUMENT,
         "layer-threshold: 'oit {}' bounds no surface's share of the picture; choose another, or 0",
         order == SIDERAY_OIT_WEIGHTED ? "weighted" : "front");
  if (v.is_raytraced() && v.translucency.refraction)
    fail(SIDERAY_INVALID_ARGUMENT, "layer-threshold: refracted rays are all traced; leave it or 'refraction' out");
}

OptionRow threshold_row() {
  OptionRow row = option_number("layer-threshold", "E", {0, 1e6}, "0",
                                "how much radiance a pixel may be off by so that rays of layers are skipped");
  row.option.applies = "hybrid and raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "0";
  row.beside_reference = "";
  row.unread = unless_traced;
  row.idle = without_layers;
  row.check = check_threshold;
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.layer_threshold = value.real(); };
  return row;
}

// Options of the layer cache.
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
                                              {"quarter", SIDERAY_RATE_QUARTER},
                                              {"temporal4", SIDERAY_RATE_TEMPORAL4},
                                              {"temporal8", SIDERAY_RATE_TEMPORAL8}},
                                             "full", "hybrid: which of the masked pixels are traced"),
                               "full");
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.cache_rate = value.as<sideray_cache_rate>();
  };
  return row;
}

OptionRow second_wave_row() {
  OptionRow row = of_the_cache(
      option_switch("second-wave", "on", "hybrid: pixels without an answer among their neighbours are traced too"),
      "on");
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.second_wave = value.on(); };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = without_layers(v)) return reason;
    return is_sparse(v.translucency.cache_rate) ? nullptr : "every masked pixel is traced in the first wave";
  };
  return row;
}

OptionRow format_row() {
  OptionRow row = of_the_cache(
      option_choice("radiance-format", {{"rgba16f", SIDERAY_RADIANCE_RGBA16F}, {"rgb9e5", SIDERAY_RADIANCE_RGB9E5}},
                    "rgba16f", "hybrid: the format in which layers keep their radiance"),
      "rgba16f");
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.radiance_format = value.as<sideray_radiance_format>();
  };
  return row;
}

OptionRow match_row() {
  OptionRow row = of_the_cache(
      option_choice("match",
                    {{"id", SIDERAY_MATCH_ID}, {"nearest", SIDERAY_MATCH_NEAREST}, {"distance", SIDERAY_MATCH_DISTANCE}},
                    "id", "hybrid: how a fragment finds its layer"),
      "id");
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.match = value.as<sideray_match>(); };
  return row;
}

OptionRow match_threshold_row() {
  OptionRow row = of_the_cache(option_number("match-threshold", "T", {1e-9, 1.0}, "0.001",
                                             "match distance: the share of the distance that a layer may be off by"),
                               "");
  row.option.applies = "hybrid with match distance";
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.match_threshold = value.real(); };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = without_layers(v)) return reason;
    return v.translucency.match == SIDERAY_MATCH_DISTANCE ? nullptr : "layers are not matched by distance alone";
  };
  return row;
}

// Options of rays through translucent surfaces.
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
                                            "multihit", "how a ray finds one surface behind the other"),
                              "multihit");
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.step = value.as<sideray_step>(); };
  row.idle = [](const OptionValues& v) {
    if (const char* reason = without_layers(v)) return reason;
    return v.is_raytraced() && v.translucency.refraction ? "refracted rays are traced from surface to surface" : nullptr;
  };
  return row;
}

OptionRow mask_row() {
  OptionRow row = of_the_rays(
      option_choice("mask", {{"none", SIDERAY_NO_MASK}, {"stencil", SIDERAY_STENCIL_MASK}, {"count", SIDERAY_COUNT_MASK}},
                    "count", "which pixels are traced"),
      "none");
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.mask = value.as<sideray_mask>(); };
  return row;
}

OptionRow refraction_row() {
  OptionRow row = option_switch("refraction", "off", "raytraced and reference: solids refract the rays through them");
  row.option.applies = "raytraced and reference";
  row.option.cost = SIDERAY_COST_PICTURE;
  row.unread = [](const OptionValues& v) {
    return v.is_raytraced() || v.is_exact() ? nullptr : "rays end at the first surface of each layer";
  };
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.refraction = value.on();
    v.reference.refraction = value.on();
  };
  return row;
}

OptionRow particles_row() {
  OptionRow row = option_switch("rt-particles", "off", "raytraced: rays hit particles");
  row.option.applies = "raytraced";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "on";
  row.beside_reference = "";
  row.unread = [](const OptionValues& v) {
    return v.is_raytraced() ? nullptr : "only raytraced translucency leaves particles to rays";
  };
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.particles = value.on(); };
  return row;
}

OptionRow order_row() {
  OptionRow row = option_choice("oit",
                                {{"sorted", SIDERAY_OIT_SORTED},
                                 {"weighted", SIDERAY_OIT_WEIGHTED},
                                 {"front", SIDERAY_OIT_FRONT},
                                 {"abuffer", SIDERAY_OIT_ABUFFER},
                                 {"peel", SIDERAY_OIT_PEEL}},
                                "sorted", "the order in which translucent fragments are blended");
  row.option.applies = "raster and hybrid";
  row.option.cost = SIDERAY_COST_TRADE;
  row.option.exact_value = "peel";
  row.beside_reference = "";
  row.unread = unless_blended;
  row.store = [](OptionValues& v, const OptionValue& value) { v.translucency.oit = value.as<sideray_oit>(); };
  return row;
}

}  // namespace

std::vector<OptionRow> translucency_rows() {
  return {method_row(),   ray_traced_row(),      layers_row(), threshold_row(), rate_row(),
          second_wave_row(), format_row(),       match_row(),  match_threshold_row(), step_row(),
          mask_row(),     refraction_row(),      particles_row(), order_row()};
}

uint32_t default_surfaces(sideray_translucency method) {
  if (method == SIDERAY_TRANSLUCENCY_RAYTRACED) return raytraced_surfaces;
  return method == SIDERAY_TRANSLUCENCY_HYBRID ? hybrid_layers : 0;
}

}  // namespace sideray::bridge
