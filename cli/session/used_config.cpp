#include "cli/session/used_config.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/options/own_options.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

// Returns numbers as numbers, everything else as text.
Json value_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return text;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<int64_t>(value);
  return value;
}

// Returns the outcome of options that leave a choice.
Json found(const RenderOptions& options, const RenderRun& run) {
  Json json = Json::object();
  if (!run.camera.empty()) json["camera"] = run.camera;
  if (!run.animation.empty()) json["animation"] = run.animation;
  if (options.free_camera && !options.projection) json["fov"] = options.free_camera->fov_deg;
  if (run.device.gl) json["gl"] = run.device.gl;
  if (run.device.id) json["device"] = run.device.id;
  if (run.stats.threads != 0) json["threads"] = run.stats.threads;
  // States as many layers as the plan uses. The surfaces along a ray are a limit, whatever there is to hit.
  if (run.layers && options.is_hybrid()) json["layers"] = *run.layers;
  if (run.ray_reuse && options.named["ray-reuse"] == "auto")
    json["ray-reuse"] = value_of(fmt::format("{}", static_cast<double>(*run.ray_reuse)));
  if (run.bounce && options.named["ambient"] == "auto") json["ambient"] = *run.bounce ? "bounce" : *run.ao ? "ao" : "off";
  if (run.reflections && options.named["reflections"] == "auto") json["reflections"] = *run.reflections ? "on" : "off";
  return json;
}

std::string text_used(const sideray_option& option, const RenderOptions& options) {
  if (sideray_option_find(option.name)) return options.named[option.name];
  return text_of(render_table(), options.given, option.name);
}

}  // namespace

Json used_config(const RenderOptions& options, const RenderRun& run) {
  const Json replaced = found(options, run);
  Json config = Json::object();
  for (const sideray_option* option : render_table()) {
    const std::string name = option->name;
    if (!is_in_config(name) || (sideray_option_find(option->name) && !options.named.reads(name))) continue;
    const std::string text = text_used(*option, options);
    if (replaced.contains(name))
      config[name] = replaced[name];
    else if (option->type == SIDERAY_OPTION_FLAG)
      config[name] = text == "true";
    else if (!text.empty())
      config[name] = value_of(text);
  }
  if (run.stats.repeats > 0) config["repeat"] = run.stats.repeats;
  return config;
}

}  // namespace sideray::cli
