// Predicts what a frame costs from two smaller ones of the same view. Arithmetic alone; any thread.
#pragma once

#include <sideray/plan.h>

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace sideray::lab {

// Work and times of a frame, whether it was drawn or is predicted.
struct FrameCost {
  uint64_t pixels = 0;
  sideray_plan_work work{};
  std::array<double, SIDERAY_STAGE_TOTAL_FRAME + 1> stage_ms{};  // medians, by sideray_stage
  double ms() const { return stage_ms[SIDERAY_STAGE_TOTAL_FRAME]; }
};

// Two frames of one view and one configuration, the second with at least as many pixels.
struct Probe {
  FrameCost small, large;
};

struct FrameSize {
  uint32_t width = 0, height = 0;
  uint64_t pixels() const { return uint64_t{width} * height; }
};

// A quarter and half of each side, but no fewer pixels than say something of the picture. A picture that has few is
// itself the larger one.
struct ProbeSizes {
  FrameSize small, large;
};
ProbeSizes probe_sizes(FrameSize whole);

// Both return what `large` measured where it has all the pixels, and nothing below 0.
// Fits a n + b sqrt(n) to n pixels: surfaces cost the first part, edges the second.
double count_at(double small_pixels, double small, double large_pixels, double large, double pixels);
// Fits a + b n with neither below 0: a frame of any size costs the first part, pixels the second.
double time_at(double small_pixels, double small, double large_pixels, double large, double pixels);

// Predicts a frame with so many pixels, drawn from so many positions one after the other. Counts stay within `most`, and
// the bytes of the cache are those of `most`. The probe is of one position.
FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions = 1);

nlohmann::json to_json(const Probe& probe);
// Empty where the JSON is no probe.
std::optional<Probe> parse_probe(const nlohmann::json& json);

}  // namespace sideray::lab
