// Computes image metrics, defined in docs/cli.md. Plain memory; any thread may call it.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/images/images.h"

namespace sideray::lab {

// Metrics that do not apply stay empty: hdr_flip of display images, ssim below 11x11, all of images with non-finite
// pixels.
struct Metrics {
  std::optional<double> flip, hdr_flip, relmse, relmse_trimmed, psnr, ssim;
  uint64_t nonfinite = 0;  // pixels, in either image
};

// Says how a linear image becomes display values.
struct Display {
  float exposure_ev = 0;
  scenes::Tonemap tonemap = scenes::Tonemap::pbr_neutral;
};

struct Comparison {
  Metrics metrics;
  std::vector<float> flip_map;  // LDR-FLIP, one a pixel, top row first; empty with non-finite pixels
};

// Throws Error where the sizes differ or an image lacks R, G or B.
Comparison compare(const scenes::Image& test, const scenes::Image& reference, const Display& display = {});

// Returns {"flip": ..., "nonfinite": ...}: only what applies.
nlohmann::ordered_json to_json(const Metrics& metrics);

// Returns the value of a metric by its JSON name; empty where it does not apply. Throws Error for an unknown name.
std::optional<double> metric(const Metrics& metrics, const std::string& name);
const std::vector<std::string>& metric_names();
bool larger_is_better(const std::string& name);

// Returns 8-bit RGB of a map of values 0..1: black, violet, orange, pale yellow.
std::vector<uint8_t> false_colours(const std::vector<float>& map);

}  // namespace sideray::lab
