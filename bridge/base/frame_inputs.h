// The inputs of a frame by value, as a host or the renderer submits them. Plain values; any thread.
#pragma once

#include <sideray/sideray.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "rt/reach/wanted_tiles.h"

namespace sideray::bridge {

// Holds what the renderer requests of a frame beyond its outputs: times, checks, occluder distances, a part of the
// tiles. Outputs stay the same, except in tiles that are not wanted.
struct Inspection {
  bool check = false;          // SIDERAY_CACHE also traces all surfaces, to compare its layers with
  bool hit_distances = false;  // masks hold the distance of every occluder near a shadow's edge
  // The previous frame of the view is traced again, for its time or for another sample position: no history advances.
  bool redraws = false;
  bool keeps_masks = false;  // with `redraws`: masks are reused, as in a view at rest
  // In a frame that does not continue: the tiles to trace of layers, and of masks and reflections; null: all.
  std::shared_ptr<const rt::WantedTiles> wanted, wanted_light;
  // Number of frames that a position of a still view has taken under a budget, this one included; 0: other views.
  uint32_t position_frames = 0;
  uint32_t position = 0;     // rt::LayerRequest::position
  bool timed = false;        // waits for the GPU around readback and upload, so that their times are separate
};

// sideray_frame_inputs with its jobs by value; the fields are explained there.
struct FrameInputs {
  sideray_view view{};
  sideray_frame_source source{};
  std::optional<sideray_layer_inputs> layers;
  std::optional<sideray_mask_inputs> masks;
  std::optional<sideray_irradiance_inputs> irradiance;
  std::optional<sideray_reflection_inputs> reflections;
  bool shadows = true;
  bool continues = false;
  uint32_t seed = 1;
  float deadline_ms = 0.0f, budget_ms = 0.0f;
  sideray_state_policy state_policy = SIDERAY_SAVE_AND_RESTORE;
  uint32_t view_id = 0;
  bool exact_points = false;  // sideray_diagnostics
  uint32_t budget_pieces = 0;
  bool resolves = false;      // rt::LayerRequest::resolves: only for the renderer
  Inspection inspection;
};

// Returns whether the frame is a second wave, which has only layers.
inline bool is_second_wave(const FrameInputs& in) {
  return in.layers && in.layers->adds_to != 0;
}

// Returns the frame's jobs, SIDERAY_JOB_*.
inline uint32_t jobs_of(const FrameInputs& in) {
  if (is_second_wave(in)) return SIDERAY_JOB_LAYERS;
  uint32_t jobs = 0;
  if (in.layers) jobs |= SIDERAY_JOB_LAYERS;
  if (in.masks) jobs |= SIDERAY_JOB_MASKS;
  if (in.irradiance) jobs |= SIDERAY_JOB_IRRADIANCE;
  if (in.reflections) jobs |= SIDERAY_JOB_REFLECTIONS;
  return jobs;
}

// Returns whether the mask of layers is in the stencil.
inline bool reads_stencil_mask(const sideray_frame_source& source) {
  return source.mask == SIDERAY_MASK_STENCIL || source.mask == SIDERAY_MASK_COUNT;
}

}  // namespace sideray::bridge
