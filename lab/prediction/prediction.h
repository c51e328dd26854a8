// What a frame costs, foretold from two smaller ones of the same view. Arithmetic alone; any thread.
#pragma once

#include <sideray/plan.h>

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace sideray::lab {

// Of one drawn frame, or of one that was not.
struct FrameCost {
  uint64_t pixels = 0;
  sideray_plan_work work{};
  std::array<double, SIDERAY_STAGE_COUNT> stage_ms{};  // medians
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
// a n + b sqrt(n) of n pixels: what surfaces cost, and what edges cost.
double count_at(double small_pixels, double small, double large_pixels, double large, double pixels);
// a + b n with neither below 0: what a frame costs whatever its size, and what pixels cost.
double time_at(double small_pixels, double small, double large_pixels, double large, double pixels);

// Of a frame with so many pixels, drawn from so many positions one after the other; counts stay within `most`, and the
// cache is what that says. The probe is of one position.
FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions = 1);

nlohmann::json to_json(const Probe& probe);
// Empty where the JSON is none.
std::optional<Probe> parse_probe(const nlohmann::json& json);

}  // namespace sideray::lab
