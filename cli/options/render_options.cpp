#include "cli/options/render_options.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"

namespace sideray::cli {
namespace {

// As the renderer accepts: sides, and pixels in all.
constexpr uint32_t largest_side_px = 16384;
constexpr uint64_t most_pixels = uint64_t{1} << 26;
constexpr uint32_t layers_auto = 4;

std::string text(const Given& given, const char* name) {
  return text_of(render_table(), given, name);
}

void set_size(const Given& given, sideray_render_options& options) {
  const std::string size = text(given, "size");
  const std::vector<std::string> sides = split(size, 'x');
  if (sides.size() != 2) wrong_usage("--size: \"{}\" is not WIDTHxHEIGHT; write for example 1280x720", size);
  if (sides[0].empty() || sides[1].empty())
    wrong_usage("--size: \"{}\" is not WIDTHxHEIGHT; write for example 1280x720", size);
  options.width = whole_number("size", sides[0], 1, largest_side_px);
  options.height = whole_number("size", sides[1], 1, largest_side_px);
  if (uint64_t{options.width} * options.height > most_pixels)
    wrong_usage("--size: {} are too many pixels; at most {} in all", size, most_pixels);
}

std::array<double, 3> point(const char* name, const std::string& given) {
  const std::vector<std::string> parts = split(given, ',');
  if (parts.size() != 3) wrong_usage("--{}: \"{}\" is not a point; write X,Y,Z", name, given);
  std::array<double, 3> p{};
  for (size_t i = 0; i < 3; ++i) p[i] = number(name, parts[i], -1e15, 1e15);
  return p;
}

void set_camera(const Given& given, RenderOptions& result) {
  result.camera = text(given, "camera");
  const bool eye = given.contains("eye"), target = given.contains("target");
  if (eye != target) wrong_usage("--{}: stands alone; give --eye and --target together", eye ? "eye" : "target");
  if (given.contains("fov") && !eye) wrong_usage("--fov: needs a free camera; give --eye and --target too");
  if (!eye) return;
  if (given.contains("camera")) wrong_usage("--eye: contradicts --camera; give one of them");
  FreeCamera camera{point("eye", given.at("eye")), point("target", given.at("target"))};
  if (camera.eye == camera.target) wrong_usage("--target: is the eye itself; give another point");
  if (given.contains("fov")) camera.fov_deg = static_cast<float>(number("fov", given.at("fov"), 0.01, 179.0));
  result.free_camera = camera;
}

sideray_translucency translucency_of(const std::string& name) {
  if (name == "raster") return SIDERAY_TRANSLUCENCY_RASTER;
  if (name == "raytraced") return SIDERAY_TRANSLUCENCY_RAYTRACED;
  if (name == "hybrid") return SIDERAY_TRANSLUCENCY_HYBRID;
  if (name == "reference") return SIDERAY_TRANSLUCENCY_REFERENCE;
  return SIDERAY_TRANSLUCENCY_OFF;
}

// 0 means unlimited to the renderer where translucency is ray traced.
uint32_t layers_of(const Given& given, sideray_translucency translucency) {
  const std::string layers = text(given, "layers");
  if (translucency == SIDERAY_TRANSLUCENCY_RAYTRACED) {
    if (layers.empty()) return 2;
    return layers == "unlimited" ? 0 : whole_number("layers", layers, 1, 64);
  }
  if (translucency == SIDERAY_TRANSLUCENCY_HYBRID)
    return layers.empty() || layers == "auto" ? layers_auto : whole_number("layers", layers, 0, 8);
  if (!layers.empty() && layers != "auto" && layers != "unlimited") whole_number("layers", layers, 0, 64);
  return 0;
}

// Options that `--reference` decides itself, and what may be said all the same.
struct Overridden {
  const char* name;
  const char* allowed;  // "" = nothing
};
constexpr Overridden overridden[] = {
    {"translucency", ""}, {"ray-traced", ""},      {"layers", ""},     {"layer-threshold", ""}, {"cache-rate", ""},
    {"second-wave", ""},  {"radiance-format", ""}, {"match", ""},      {"match-threshold", ""}, {"step", ""},
    {"mask", ""},         {"rt-particles", ""},    {"oit", ""},        {"shadows", "off"},      {"inexact", ""},
    {"inexact-bias", ""}, {"inexact-target", ""},  {"foliage", ""},    {"shared-copies", ""},   {"unique-cap", ""},
    {"cull-angle", ""},   {"denoise", "off"},      {"denoise-on", ""}, {"taa", "off"},          {"deadline", ""},
    {"max-ms", ""},       {"max-error", ""}};

void set_reference(const Given& given, sideray_render_options& options) {
  options.reference = given.contains("reference");
  const bool samples_lights = options.reference || options.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
  if (given.contains("light-samples") && !samples_lights)
    wrong_usage("--light-samples: nothing is sampled; give --reference or --translucency reference too");
  options.light_samples = whole_number("light-samples", text(given, "light-samples"), 1, 1u << 20);
  if (!options.reference) return;
  for (const Overridden& option : overridden) {
    const auto at = given.find(option.name);
    if (at == given.end() || at->second == option.allowed) continue;
    wrong_usage("--reference: contradicts --{}, which it decides itself; leave one of them out", option.name);
  }
}

// The place of the option's value among its values: enumerations of the interface have the same order.
template <typename Enumeration>
Enumeration value_of(const Given& given, const char* name) {
  const std::string chosen = text(given, name);
  for (const Option& option : render_table()) {
    if (option.name != name) continue;
    const auto at = std::find(option.values.begin(), option.values.end(), chosen);
    return static_cast<Enumeration>(at - option.values.begin());
  }
  wrong_usage("--{}: no such option; see sideray render --help", name);
}

bool is_on(const Given& given, const char* name) {
  return text(given, name) == "on";
}

void set_layer_threshold(const Given& given, sideray_render_options& options) {
  options.layer_threshold = static_cast<float>(number("layer-threshold", text(given, "layer-threshold"), 0, 1e6));
  if (options.layer_threshold == 0.0f || options.reference) return;
  const bool hybrid = options.translucency == SIDERAY_TRANSLUCENCY_HYBRID;
  if (hybrid && (options.oit == SIDERAY_OIT_WEIGHTED || options.oit == SIDERAY_OIT_FRONT))
    wrong_usage("--layer-threshold: --oit {} bounds no surface's share of the picture; choose another, or 0",
                text(given, "oit"));
  if (options.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED && options.refraction)
    wrong_usage("--layer-threshold: bent rays are all traced; leave it or --refraction out");
}

void set_translucency(const Given& given, sideray_render_options& options) {
  options.mask = value_of<sideray_mask>(given, "mask");
  options.match = value_of<sideray_match>(given, "match");
  options.match_threshold = static_cast<float>(number("match-threshold", text(given, "match-threshold"), 1e-9, 1.0));
  options.step = value_of<sideray_step>(given, "step");
  options.cache_rate = value_of<sideray_cache_rate>(given, "cache-rate");
  options.second_wave = is_on(given, "second-wave");
  options.radiance_format = value_of<sideray_radiance_format>(given, "radiance-format");
  options.refraction = is_on(given, "refraction");
  options.rt_particles = is_on(given, "rt-particles");
  options.oit = value_of<sideray_oit>(given, "oit");
  options.denoise = is_on(given, "denoise");
  options.denoise_on = value_of<sideray_denoise_on>(given, "denoise-on");
  set_layer_threshold(given, options);
  options.check = given.contains("check");
  if (options.check && (options.reference || options.translucency != SIDERAY_TRANSLUCENCY_HYBRID))
    wrong_usage("--check: only hybrid translucency has layers to check; choose it, or leave --check out");
}

scenes::Tonemap tonemap_of(const std::string& name) {
  if (name == "none") return scenes::Tonemap::none;
  if (name == "reinhard") return scenes::Tonemap::reinhard;
  return name == "aces" ? scenes::Tonemap::aces : scenes::Tonemap::pbr_neutral;
}

void set_environment(const Given& given, RenderOptions& result) {
  result.environment = text(given, "env");
  if (result.environment != "sky" && result.environment != "none")
    require_extension("--env", result.environment, {".exr", ".hdr"});
  result.environment_scale = static_cast<float>(number("env-scale", text(given, "env-scale"), 0, 1e6));
  result.environment_rotation_deg = static_cast<float>(number("env-rotate", text(given, "env-rotate"), -36000, 36000));
}

void set_outputs(const Given& given, RenderOptions& result) {
  result.output = text(given, "o");
  if (result.output.empty()) wrong_usage("render: no output; give -o IMAGE");
  result.exr = require_extension("-o", result.output, {".exr", ".png"}) == ".exr";
  if (result.frames) check_frame_pattern(result.output);
  result.stats = text(given, "stats");
  if (result.stats == "-") wrong_usage("--stats -: standard output is not a file; give a file name");
  result.reference = text(given, "compare");
  result.comparison = resolve_comparison(given);
  if (!result.reference.empty()) return;
  for (const Option& option : comparison_options())
    if (given.contains(option.name)) wrong_usage("--{}: has nothing to compare; give --compare REF too", option.name);
}

void check_files(const RenderOptions& result) {
  // Built-in names and words are no paths.
  const bool is_file = result.scene.ends_with(".gltf") || result.scene.ends_with(".glb");
  const bool is_picture = result.environment != "sky" && result.environment != "none";
  require_distinct({{"-o", result.output}, {"--stats", result.stats}, {"--map", result.comparison.map}},
                   {{"--compare", result.reference},
                    {"--env", is_picture ? result.environment : ""},
                    {"SCENE", is_file ? result.scene : ""}});
}

// What the bound is for must exist for such a picture; the reference is looked at later.
void check_metric(const RenderOptions& result) {
  const Bound& bound = result.comparison.bound;
  if (!bound.fail_above && !bound.fail_below) return;
  if (bound.metric == "hdr_flip" && (!result.exr || result.reference.ends_with(".png")))
    wrong_usage("--metric hdr_flip: needs linear images; use .exr for -o and --compare, or another metric");
  if (bound.metric == "ssim" && (result.options.width < 11 || result.options.height < 11))
    wrong_usage("--metric ssim: needs 11x11 pixels; raise --size or choose another metric");
}

void set_aovs(const Given& given, RenderOptions& result) {
  if (!given.contains("aov")) return;
  if (!result.exr) wrong_usage("--aov: needs an .exr output; a .png holds colours only");
  const sideray_render_options& o = result.options;
  const uint32_t layers = o.translucency == SIDERAY_TRANSLUCENCY_HYBRID ? o.layers : 0;
  const bool inexact = !o.reference && o.shadows == SIDERAY_SHADOWS_INEXACT;
  const bool masks = inexact || (!o.reference && o.shadows == SIDERAY_SHADOWS_EXACT);
  result.aovs = parse_aovs(given.at("aov"), {layers, masks, inexact, o.reference != 0});
}

void set_shadows(const Given& given, sideray_render_options& options) {
  const auto text = [&](const char* name) { return text_of(render_table(), given, name); };
  const std::string shadows = text("shadows"), inexact = text("inexact"), target = text("inexact-target");
  options.shadows = shadows == "off"       ? SIDERAY_SHADOWS_OFF
                    : shadows == "map"     ? SIDERAY_SHADOWS_MAP
                    : shadows == "inexact" ? SIDERAY_SHADOWS_INEXACT
                                           : SIDERAY_SHADOWS_EXACT;
  options.inexact = inexact == "tmin"      ? SIDERAY_INEXACT_TMIN
                    : inexact == "bounded" ? SIDERAY_INEXACT_BOUNDED
                                           : SIDERAY_INEXACT_RESTPOSE;
  options.inexact_target = target == "model" ? SIDERAY_TARGET_MODEL
                           : target == "bit" ? SIDERAY_TARGET_BIT
                                             : SIDERAY_TARGET_STENCIL;
  options.inexact_bias = static_cast<float>(number("inexact-bias", text("inexact-bias"), 0, 1e6));
  options.ao = text("ao") == "on";
  options.reflections = text("reflections") == "on";
  const std::string foliage = text("foliage"), cap = text("unique-cap");
  options.foliage = foliage == "static"   ? SIDERAY_FOLIAGE_STATIC
                    : foliage == "shared" ? SIDERAY_FOLIAGE_SHARED
                                          : SIDERAY_FOLIAGE_UNIQUE;
  options.shared_copies = whole_number("shared-copies", text("shared-copies"), 1, 256);
  options.cull_angle_deg = static_cast<float>(number("cull-angle", text("cull-angle"), 0, 90));
  options.unique_cap = cap == "none" ? 0 : whole_number("unique-cap", cap, 1, 100000000);
}

void set_bounds(const Given& given, RenderOptions& result) {
  if (given.contains("max-ms")) result.bounds.most_ms = number("max-ms", given.at("max-ms"), 1e-3, 1e9);
  if (given.contains("max-error")) result.bounds.most_error = number("max-error", given.at("max-error"), 0, 1);
  if (result.bounds.any() && result.options.translucency == SIDERAY_TRANSLUCENCY_REFERENCE)
    wrong_usage("--{}: --translucency reference leaves nothing to choose; leave one of them out",
                result.bounds.most_ms ? "max-ms" : "max-error");
}

void set_taa(const Given& given, RenderOptions& result) {
  const std::string taa = text(given, "taa");
  sideray_render_options& o = result.options;
  const bool is_average = o.samples > 1 || o.reference != 0 || o.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
  if (taa == "on" && is_average)
    wrong_usage("--taa on: pictures of several samples and references are averages already; leave it out");
  o.taa = result.frames && !is_average && taa != "off";
}

void set_deadline(const Given& given, sideray_render_options& options) {
  if (!given.contains("deadline")) return;
  if (options.translucency == SIDERAY_TRANSLUCENCY_REFERENCE)
    wrong_usage("--deadline: --translucency reference takes the time that it needs; leave one of them out");
  options.deadline_ms = static_cast<float>(number("deadline", given.at("deadline"), 1e-3, 1e9));
}

std::string pinned_isa() {
  const char* isa = std::getenv("SIDERAY_ISA");
  const std::string name = isa ? isa : "";
  if (!name.empty() && name != "sse4.2" && name != "avx2" && name != "avx512")
    wrong_usage("SIDERAY_ISA: unknown value \"{}\"; one of sse4.2, avx2, avx512", name);
  return name;
}

}  // namespace

void erase_overridden(Given& given) {
  for (const Overridden& option : overridden) {
    const auto at = given.find(option.name);
    if (at != given.end() && at->second != option.allowed) given.erase(at);
  }
}

RenderOptions resolve_render(const std::string& scene, const Given& given) {
  check_given(render_table(), given);
  if (scene.empty())
    wrong_usage("render: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  RenderOptions result;
  result.given = given;
  result.scene = scene;
  result.options = sideray_render_defaults();
  sideray_render_options& options = result.options;
  result.animation = text(given, "animation");
  if (given.contains("animation") && result.animation.empty()) wrong_usage("--animation: is empty; give a name or all");
  result.time_s = number("time", text(given, "time"), 0, 1e9);
  result.frames = frame_range(given);
  result.resume = given.contains("resume");
  set_size(given, options);
  set_camera(given, result);
  result.gl = text(given, "gl");
  result.device = text(given, "device");
  result.isa = pinned_isa();
  if (given.contains("threads")) result.threads = whole_number("threads", given.at("threads"), 1, 1024);
  options.translucency = translucency_of(text(given, "translucency"));
  set_reference(given, options);
  options.layers = layers_of(given, options.translucency);
  result.ray_traced = text(given, "ray-traced");
  set_translucency(given, options);
  set_shadows(given, options);
  set_bounds(given, result);
  options.samples = whole_number("samples", text(given, "samples"), 1, 4096);
  set_taa(given, result);
  set_deadline(given, options);
  options.seed = whole_number("seed", text(given, "seed"), 0, UINT32_MAX);
  set_environment(given, result);
  result.display.exposure_ev = static_cast<float>(number("exposure", text(given, "exposure"), -64, 64));
  result.display.tonemap = tonemap_of(text(given, "tonemap"));
  const uint32_t repeats = whole_number("repeat", text(given, "repeat"), 1, 10000);
  set_outputs(given, result);
  check_files(result);
  check_metric(result);
  options.repeats = result.stats.empty() ? 0 : repeats;
  set_aovs(given, result);
  options.aovs = result.aovs.bits;
  return result;
}

}  // namespace sideray::cli
