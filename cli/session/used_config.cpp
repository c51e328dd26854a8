#include "cli/session/used_config.h"

#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

// Numbers as numbers, everything else as text.
Json value_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return text;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<int64_t>(value);
  return value;
}

// Of layers no more than the plan has a use for; events are a limit, whatever there is to meet.
Json layers_used(const sideray_render_options& o, const RenderRun& run) {
  if (o.translucency == SIDERAY_TRANSLUCENCY_HYBRID) return run.layers;
  if (o.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED && o.layers == 0) return "unlimited";
  return o.layers;
}

// What draws the translucent surfaces, as a set.
enum Drawing : unsigned { nothing = 0, blended = 1, layered = 2, composited = 4, exact = 8 };

Drawing drawing_of(const RenderOptions& options) {
  if (options.given.contains("reference")) return exact;
  switch (options.options.translucency) {
    case SIDERAY_TRANSLUCENCY_HYBRID:
      return layered;
    case SIDERAY_TRANSLUCENCY_RAYTRACED:
      return composited;
    case SIDERAY_TRANSLUCENCY_REFERENCE:
      return exact;
    case SIDERAY_TRANSLUCENCY_OFF:
      return nothing;
    default:
      return blended;
  }
}

// Options that only some ways of drawing have a use for; all others always count.
const std::map<std::string, unsigned>& limited_options() {
  static const std::map<std::string, unsigned> limits{{"ray-traced", layered},
                                                      {"layers", layered | composited},
                                                      {"layer-threshold", layered | composited},
                                                      {"cache-rate", layered},
                                                      {"second-wave", layered},
                                                      {"radiance-format", layered},
                                                      {"match", layered},
                                                      {"match-threshold", layered},
                                                      {"step", layered | composited},
                                                      {"mask", layered | composited},
                                                      {"refraction", composited | exact},
                                                      {"rt-particles", composited},
                                                      {"oit", blended | layered},
                                                      {"light-samples", exact},
                                                      {"check", layered}};
  return limits;
}

bool has_masks(const sideray_render_options& o) {
  return !o.reference && (o.shadows == SIDERAY_SHADOWS_EXACT || o.shadows == SIDERAY_SHADOWS_INEXACT || o.ao);
}

bool is_used(const std::string& name, const RenderOptions& options) {
  if (name.starts_with("inexact")) return text_of(render_table(), options.given, "shadows") == "inexact";
  if (name.starts_with("denoise"))
    return has_masks(options.options) || (name == "denoise" && drawing_of(options) == layered);
  const auto limit = limited_options().find(name);
  return limit == limited_options().end() || (limit->second & drawing_of(options)) != 0;
}

}  // namespace

Json used_config(const RenderOptions& options, const RenderRun& run) {
  Json config = Json::object();
  for (const Option& option : render_table()) {
    if (!option.in_config || !is_used(option.name, options)) continue;
    const std::string text = text_of(render_table(), options.given, option.name);
    if (option.kind == Option::Kind::flag)
      config[option.name] = options.given.contains(option.name);
    else if (option.name == "camera" && !text.empty())
      config["camera"] = text;
    else if (!text.empty())
      config[option.name] = value_of(text);
    if (option.name == "camera" && !run.camera.empty()) config["camera"] = run.camera;
    if (option.name == "animation" && !run.animation.empty()) config["animation"] = run.animation;
    if (option.name == "fov" && options.free_camera) config["fov"] = options.free_camera->fov_deg;
    if (option.name == "gl" && run.device.gl) config["gl"] = run.device.gl;
    if (option.name == "device" && run.device.id) config["device"] = run.device.id;
    if (option.name == "translucency" && options.options.reference) config["translucency"] = "reference";
    if (option.name == "taa") config["taa"] = options.options.taa ? "on" : "off";
    if (option.name == "layers") config["layers"] = layers_used(options.options, run);
    if (option.name == "shadows" && options.options.reference && options.options.shadows != SIDERAY_SHADOWS_OFF)
      config["shadows"] = "exact";
    if (option.name == "threads" && run.stats.threads != 0) config["threads"] = run.stats.threads;
  }
  return config;
}

}  // namespace sideray::cli
