// Predicts the cost of a frame from two smaller frames of the same view. Arithmetic alone; any thread may call it.
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

// Holds two frames of one view and one configuration, the second with at least as many pixels.
struct Probe {
  FrameCost small, large;
};

struct FrameSize {
  uint32_t width = 0, height = 0;
  uint64_t pixels() const { return uint64_t{width} * height; }
};

// Holds the sizes of the probe's frames: a quarter and a half of each side, but no fewer pixels than predict anything.
// The larger frame of a small picture is the whole picture.
struct ProbeSizes {
  FrameSize small, large;
};
ProbeSizes probe_sizes(FrameSize whole);

// Both functions return `large` where its frame has all the pixels, and never less than 0. This one fits a n + b
// sqrt(n) for n pixels: the cost of surfaces plus that of edges.
double count_at(double small_pixels, double small, double large_pixels, double large, double pixels);
// Fits a + b n with a, b >= 0: a fixed cost of the frame plus the cost of its pixels.
double time_at(double small_pixels, double small, double large_pixels, double large, double pixels);

// Predicts a frame of `pixels` pixels, drawn from `positions` camera positions one after the other. Counts stay within
// `most`, which also gives the bytes of the cache. The probe is of one position.
FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions = 1);

nlohmann::json to_json(const Probe& probe);
// Returns nothing where the JSON does not hold a probe.
std::optional<Probe> parse_probe(const nlohmann::json& json);

}  // namespace sideray::lab
