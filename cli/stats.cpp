#include "stats.h"

#include <charconv>
#include <cmath>

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

// In the order of sideray_stage.
constexpr const char* stage_names[] = {"load",    "build",    "update", "gbuffer",      "shadow_map",
                                       "mask",    "readback", "trace",  "trace_shadow", "trace_ao",
                                       "denoise", "upload",   "light",  "composite",    "total_frame"};
static_assert(std::size(stage_names) == SIDERAY_STAGE_COUNT);

// Numbers as numbers, everything else as text.
Json value_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return text;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<int64_t>(value);
  return value;
}

Json layers_used(const sideray_render_options& o) {
  if (o.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED && o.layers == 0) return "unlimited";
  return o.layers;
}

std::string ray_traced_used(const RenderOptions& options) {
  switch (options.options.translucency) {
    case SIDERAY_TRANSLUCENCY_HYBRID:
      return options.ray_traced;
    case SIDERAY_TRANSLUCENCY_RAYTRACED:
      return "all";
    default:
      return "none";
  }
}

Json config_json(const RenderOptions& options, const RenderRun& run) {
  Json config = Json::object();
  for (const Option& option : render_table()) {
    if (!option.in_config) continue;
    const std::string text = text_of(render_table(), options.given, option.name);
    if (option.kind == Option::Kind::flag)
      config[option.name] = options.given.contains(option.name);
    else if (option.name == "camera" && !text.empty())
      config["camera"] = text;
    else if (!text.empty())
      config[option.name] = value_of(text);
    if (option.name == "camera" && !run.camera.empty()) config["camera"] = run.camera;
    if (option.name == "fov" && options.free_camera) config["fov"] = options.free_camera->fov_deg;
    if (option.name == "gl") config["gl"] = run.device.gl;
    if (option.name == "device") config["device"] = run.device.id;
    if (option.name == "ray-traced") config["ray-traced"] = ray_traced_used(options);
    if (option.name == "layers") config["layers"] = layers_used(options.options);
    if (option.name == "threads" && run.stats.threads != 0) config["threads"] = run.stats.threads;
  }
  return config;
}

Json device_json(const RenderRun& run) {
  Json device = {{"gl", run.device.gl}, {"renderer", run.device.renderer}, {"version", run.device.version}};
  if (run.stats.embree[0] != '\0') device["embree"] = run.stats.embree;
  if (run.stats.threads != 0) device["threads"] = run.stats.threads;
  if (run.stats.isa[0] != '\0') device["isa"] = run.stats.isa;
  return device;
}

Json stages_json(const RenderRun& run, double sideray_quartiles::*quartile) {
  Json stages = Json::object();
  for (size_t i = 0; i < SIDERAY_STAGE_COUNT; ++i) {
    const double ms = i == SIDERAY_STAGE_LOAD ? run.load_ms : run.stats.stage_ms[i].*quartile;
    stages[stage_names[i]] = std::isfinite(ms) ? ms : 0.0;
  }
  return stages;
}

}  // namespace

Json stats_json(const RenderOptions& options, const RenderRun& run) {
  const sideray_render_stats& s = run.stats;
  const sideray_translucency translucency = options.options.translucency;
  const bool hybrid = translucency == SIDERAY_TRANSLUCENCY_HYBRID;
  const bool traces = hybrid || translucency == SIDERAY_TRANSLUCENCY_RAYTRACED;
  Json json;
  json["schema"] = 1;
  json["scene"] = {{"triangles", s.triangles},
                   {"instances", s.instances},
                   {"materials", s.materials},
                   {"translucent_objects", s.translucent_objects}};
  json["config"] = config_json(options, run);
  json["device"] = device_json(run);
  json["stages_ms"] = stages_json(run, &sideray_quartiles::median);
  json["p25"] = stages_json(run, &sideray_quartiles::p25);
  json["p75"] = stages_json(run, &sideray_quartiles::p75);
  json["rays"] = {{"primary", s.rays_primary},
                  {"reflection", s.rays_reflection},
                  {"shadow", s.rays_shadow},
                  {"ao", s.rays_ao},
                  {"total", s.rays_primary + s.rays_reflection + s.rays_shadow + s.rays_ao}};
  json["pixels"] = {{"total", s.pixels_total}};
  if (traces) {
    json["pixels"]["masked"] = s.pixels_masked;
    if (options.options.mask == SIDERAY_COUNT_MASK) json["layers"]["requested"] = s.layers_requested;
    json["layers"]["found"] = s.layers_found;
    if (hybrid) json["layers"]["matched"] = s.layers_matched;
    if (hybrid) json["layers"]["missed"] = s.layers_missed;
    json["layers"]["wasted"] = s.traversals_wasted;
    json["bytes"] = {{"readback", s.bytes_readback}, {"upload", s.bytes_upload}, {"cache", s.bytes_cache}};
  }
  json["repeats"] = s.repeats;
  return json;
}

}  // namespace sideray::cli
