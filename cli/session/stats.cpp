#include "cli/session/stats.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/session/used_config.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

// In the order of sideray_stage.
constexpr const char* stage_names[] = {"load",    "build",    "update", "gbuffer",      "shadow_map",
                                       "mask",    "readback", "trace",  "trace_shadow", "trace_ao",
                                       "denoise", "upload",   "light",  "composite",    "total_frame"};
static_assert(std::size(stage_names) == SIDERAY_STAGE_COUNT);

// Whether surfaces are met in the order of rays, to the last one.
bool is_exact(const sideray_render_options& o) {
  return o.reference || o.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
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

const char* stage_name(sideray_stage stage) {
  return stage_names[stage];
}

Json stats_json(const RenderOptions& options, const RenderRun& run) {
  const sideray_render_stats& s = run.stats;
  const sideray_translucency translucency = options.options.translucency;
  const bool exact = is_exact(options.options);
  const bool hybrid = !exact && translucency == SIDERAY_TRANSLUCENCY_HYBRID;
  const bool traces = hybrid || exact || translucency == SIDERAY_TRANSLUCENCY_RAYTRACED;
  Json json;
  json["schema"] = 1;
  json["scene"] = {{"triangles", s.triangles},
                   {"instances", s.instances},
                   {"materials", s.materials},
                   {"translucent_objects", s.translucent_objects}};
  json["config"] = used_config(options, run);
  json["device"] = device_json(run);
  json["stages_ms"] = stages_json(run, &sideray_quartiles::median);
  json["p25"] = stages_json(run, &sideray_quartiles::p25);
  json["p75"] = stages_json(run, &sideray_quartiles::p75);
  json["rays"] = {{"primary", s.rays_primary},
                  {"reflection", s.rays_reflection},
                  {"shadow", s.rays_shadow},
                  {"ao", s.rays_ao},
                  {"total", s.rays_primary + s.rays_reflection + s.rays_shadow + s.rays_ao}};
  const bool spares = traces && !exact && options.options.layer_threshold > 0.0f;
  if (spares) json["rays"]["spared"] = s.rays_spared;
  json["pixels"] = {{"total", s.pixels_total}};
  if (traces) {
    if (!exact && options.options.mask != SIDERAY_NO_MASK) json["pixels"]["masked"] = s.pixels_masked;
    if (options.options.deadline_ms > 0.0f) json["pixels"]["late"] = s.pixels_late;
    if (!exact && options.options.mask == SIDERAY_COUNT_MASK) json["layers"]["requested"] = s.layers_requested;
    json["layers"]["found"] = s.layers_found;
    if (hybrid) json["layers"]["matched"] = s.layers_matched;
    if (hybrid) json["layers"]["missed"] = s.layers_missed;
    json["layers"]["wasted"] = s.traversals_wasted;
    if (spares) json["layers"]["skipped"] = s.layers_skipped;
    if (options.options.check) json["layers"]["misassigned"] = s.layers_misassigned;
    if (options.options.check) json["layers"]["duplicated"] = s.layers_duplicated;
    if (!options.options.reference)
      json["bytes"] = {{"readback", s.bytes_readback}, {"upload", s.bytes_upload}, {"cache", s.bytes_cache}};
  }
  if (!exact && translucency == SIDERAY_TRANSLUCENCY_RAYTRACED) json["dropped_particles"] = s.dropped_particles;
  if (s.reference_light_samples != 0) {
    json["reference"] = {{"light_samples", s.reference_light_samples}};
    if (s.reference_self_error >= 0.0) json["reference"]["self_error"] = s.reference_self_error;
  }
  json["repeats"] = s.repeats;
  return json;
}

}  // namespace sideray::cli
