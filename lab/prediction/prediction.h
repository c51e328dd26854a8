// Predicts what a frame costs from two smaller ones of the same view. Arithmetic alone; any thread may call it.
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

// Holds the sizes of the probe's frames: a quarter and half of each side, but no fewer pixels than say something of the
// picture. A picture that has few is itself the larger one.
struct ProbeSizes {
  FrameSize small, large;
};
ProbeSizes probe_sizes(FrameSize whole);

// Both functions return what `large` measured where it has all the pixels, and nothing below 0. This one fits a n + b
// sqrt(n) for n pixels: what surfaces cost, and what edges cost.
double count_at(double small_pixels, double small, double large_pixels, double large, double pixels);
// Fits a + b n with neither below 0: what a frame costs whatever its size, and what pixels cost.
double time_at(double small_pixels, double small, double large_pixels, double large, double pixels);

// Predicts a frame with so many pixels, drawn from so many positions one after the other; counts stay within `most`,
// and the bytes of the cache are taken from it. The probe is of one position.
FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions = 1);

nlohmann::json to_json(const Probe& probe);
// Returns nothing where the JSON is no probe.
std::optional<Probe> parse_probe(const nlohmann::json& json);

}  // namespace sideray::lab
