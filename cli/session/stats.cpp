#include "cli/session/stats.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/session/used_config.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

Json device_json(const RenderRun& run) {
  Json device = {{"gl", run.device.gl}, {"renderer", run.device.renderer}, {"version", run.device.version}};
  if (run.stats.embree[0] != '\0') device["embree"] = run.stats.embree;
  if (run.stats.threads != 0) device["threads"] = run.stats.threads;
  if (run.stats.isa[0] != '\0') device["isa"] = run.stats.isa;
  return device;
}

// Returns whether the picture was drawn again, to time it and to count its fragments.
bool is_measured(const RenderRun& run) {
  return run.stats.repeats > 0;
}

// Returns whether the stage is timed in the picture itself; OpenGL's stages would need fences around them.
bool is_timed_as_drawn(const sideray_stage_time& time) {
  switch (time.stage) {
    case SIDERAY_STAGE_LOAD:
    case SIDERAY_STAGE_BUILD:
    case SIDERAY_STAGE_UPDATE:
    case SIDERAY_STAGE_TRACE:
    case SIDERAY_STAGE_TRACE_SHADOW:
    case SIDERAY_STAGE_TRACE_AO:
    case SIDERAY_STAGE_DENOISE:
    case SIDERAY_STAGE_TOTAL_FRAME:
      return true;
    default:
      return false;
  }
}

Json stages_json(const RenderRun& run, double sideray_stage_time::*quartile) {
  Json stages = Json::object();
  for (const sideray_stage_time& time : run.stages)
    if (is_measured(run) || is_timed_as_drawn(time))
      stages[time.name] = std::isfinite(time.*quartile) ? time.*quartile : 0.0;
  return stages;
}

Json raw_frame_json(const RenderRun& run) {
  const sideray_raw_frame& raw = run.raw_frame;
  Json stages = Json::object();
  for (const sideray_stage_time& time : run.stages)
    if (is_of_rays(time)) stages[time.name] = time.median / raw.ms;
  Json json = {{"ms", raw.ms}, {"triangles", raw.triangles}, {"flat", raw.is_flat != 0}, {"stages", stages}};
  for (const sideray_stage_time& time : run.stages)
    if (time.stage == SIDERAY_STAGE_TOTAL_FRAME) json["total"] = time.median / raw.ms;
  return json;
}

// Adds counters that only translucency has.
void add_translucency(const RenderOptions& options, const RenderRun& run, Json& json) {
  const sideray_render_stats& s = run.stats;
  const sideray_render_options& o = options.named.render();
  const sideray_translucency_options& t = *o.translucency;
  const bool exact = options.is_exact(), hybrid = options.is_hybrid();
  json["layers"] = Json::object();
  if (!exact && t.mask != SIDERAY_NO_MASK) json["pixels"]["masked"] = s.pixels_masked;
  const bool is_bounded = o.deadline_ms > 0.0f || o.budget_ms > 0.0f;
  if (is_bounded) json["pixels"]["late"] = s.pixels_late;
  if (is_bounded && hybrid) {
    json["pixels"]["older"] = s.pixels_older;
    json["pixels"]["masks_late"] = s.mask_pixels_late;
    json["pixels"]["masks_older"] = s.mask_pixels_older;
    json["pixels"]["reflections_late"] = s.reflection_pixels_late;
    json["pixels"]["reflections_older"] = s.reflection_pixels_older;
    json["pixels"]["irradiance_late"] = s.irradiance_pixels_late;
    json["pixels"]["irradiance_older"] = s.irradiance_pixels_older;
    json["pixels"]["oldest_frames"] = s.answer_age;
    json["starved"] = s.jobs_starved;
  }
  if (!exact && t.mask == SIDERAY_COUNT_MASK) json["layers"]["requested"] = s.layers_requested;
  json["layers"]["found"] = s.layers_found;
  if (hybrid && (is_measured(run) || t.check)) {
    json["layers"]["matched"] = s.layers_matched;
    json["layers"]["missed"] = s.layers_missed;
  }
  json["layers"]["wasted"] = s.traversals_wasted;
  if (s.layers_refracted > 0) json["layers"]["refracted"] = s.layers_refracted;
  if (run.ray_reuse.value_or(0.0f) > 0.0f) json["layers"]["borrowed"] = s.layers_borrowed;
  if (t.check) json["layers"]["misassigned"] = s.layers_misassigned;
  if (t.check) json["layers"]["duplicated"] = s.layers_duplicated;
  if (!o.reference)
    json["bytes"] = {{"readback", s.bytes_readback}, {"upload", s.bytes_upload}, {"cache", s.bytes_cache}};
}

}  // namespace

Json choice_json(const ChoiceSummary& choice) {
  Json json = Json::object();
  if (choice.predicted_ms) json["predicted_ms"] = *choice.predicted_ms;
  if (choice.measured_ms) json["measured_ms"] = *choice.measured_ms;
  if (choice.error) json["error"] = *choice.error;
  json["corrections"] = choice.corrections;
  json["scale"] = choice.scale;
  return json;
}

Json stats_json(const RenderOptions& options, const RenderRun& run) {
  const sideray_render_stats& s = run.stats;
  const bool exact = options.is_exact();
  const bool raytraced = !exact && options.translucency() == SIDERAY_TRANSLUCENCY_RAYTRACED;
  const bool traces = exact || raytraced || options.is_hybrid();
  // Starts as an object: nlohmann 3.11.2 leaves null broken where it becomes an object and memory runs out.
  Json json = Json::object();
  json["schema"] = 1;
  json["scene"] = {{"triangles", s.triangles},
                   {"instances", s.instances},
                   {"materials", s.materials},
                   {"translucent_objects", s.translucent_objects}};
  json["config"] = used_config(options, run);
  if (options.choice) json["choice"] = choice_json(*options.choice);
  json["device"] = device_json(run);
  json["stages_ms"] = stages_json(run, &sideray_stage_time::median);
  if (is_measured(run)) {
    json["p25"] = stages_json(run, &sideray_stage_time::p25);
    json["p75"] = stages_json(run, &sideray_stage_time::p75);
  }
  json["rays"] = {{"primary", s.rays_primary},
                  {"reflection", s.rays_reflection},
                  {"shadow", s.rays_shadow},
                  {"ao", s.rays_ao},
                  {"bounce", s.rays_bounce},
                  {"total", s.rays_primary + s.rays_reflection + s.rays_shadow + s.rays_ao + s.rays_bounce}};
  json["pixels"] = {{"total", s.pixels_total}, {"positions", s.positions}};
  if (traces) add_translucency(options, run, json);
  if (raytraced) json["dropped_particles"] = s.dropped_particles;
  if (s.reference_light_samples != 0) {
    json["reference"] = {{"light_samples", s.reference_light_samples}};
    if (s.reference_bounces == 0)
      json["reference"]["bounces"] = "unlimited";
    else
      json["reference"]["bounces"] = s.reference_bounces;
    if (s.reference_bounces != 1) json["reference"]["caustics"] = s.reference_caustics != 0;
    if (s.reference_self_error >= 0.0) {
      json["reference"]["self_error"] = s.reference_self_error;
      json["reference"]["firefly_share"] = s.reference_firefly_share;
    }
  }
  if (run.raw_frame.ms > 0.0) json["raw_frame"] = raw_frame_json(run);
  if (is_measured(run)) json["repeats"] = s.repeats;
  return json;
}

bool is_of_rays(const sideray_stage_time& time) {
  switch (time.stage) {
    case SIDERAY_STAGE_TRACE:
    case SIDERAY_STAGE_TRACE_SHADOW:
    case SIDERAY_STAGE_TRACE_AO:
    case SIDERAY_STAGE_DENOISE:
    case SIDERAY_STAGE_UPLOAD:
      return true;
    default:
      return false;
  }
}

}  // namespace sideray::cli
