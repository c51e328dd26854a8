// Predicts the cost of a frame from two smaller ones of the same view. Only arithmetic; any thread may call it.
#pragma once

#include <sideray/plan.h>

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace sideray::lab {

// Holds the cost of one frame, drawn or predicted.
struct FrameCost {
  uint64_t pixels = 0;
  sideray_plan_work work{};
  std::array<double, SIDERAY_STAGE_TOTAL_FRAME + 1> stage_ms{};  // medians, by sideray_stage
  double ms() const { return stage_ms[SIDERAY_STAGE_TOTAL_FRAME]; }
};

// Holds two frames of one view and configuration, the second with at least as many pixels.
struct Probe {
  FrameCost small, large;
};

struct FrameSize {
  uint32_t width = 0, height = 0;
  uint64_t pixels() const { return uint64_t{width} * height; }
};

// Holds the sizes of the probe's frames: a quarter and half of each side, but not too few pixels to represent the
// picture. A picture with few pixels is itself the larger frame.
struct ProbeSizes {
  FrameSize small, large;
};
ProbeSizes probe_sizes(FrameSize whole);

// Both functions return the measurement of `large` if it has all pixels, and never less than 0. This one fits a n + b
// sqrt(n) for n pixels: the cost of surfaces, and of edges.
double count_at(double small_pixels, double small, double large_pixels, double large, double pixels);
// Fits a + b n with neither below 0: a frame's fixed cost, and the cost of pixels.
double time_at(double small_pixels, double small, double large_pixels, double large, double pixels);

// Predicts a frame with `pixels` pixels, drawn from `positions` sample positions in turn. Counts are limited by `most`,
// which also gives the bytes of the cache. The probe must have one position.
FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions = 1);

nlohmann::json to_json(const Probe& probe);
// Returns nothing if the JSON is no probe.
std::optional<Probe> parse_probe(const nlohmann::json& json);

}  // namespace sideray::lab
