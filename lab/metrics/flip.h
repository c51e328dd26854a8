// Computes FLIP: Andersson et al., "FLIP: A Difference Evaluator for Alternating Images" (2020), and "Visualizing the
// Error in Rendered High Dynamic Range Images" (2021). Plain memory; any thread may call it; it uses all cores, with
// the same bits for any thread count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sideray::lab {

// A viewer is 0.7 m from a 0.7 m wide monitor of 3840 pixels.
constexpr double flip_pixels_per_degree = 67.0206;

struct FlipMap {
  std::vector<float> error;  // 0..1, one a pixel
  double mean = 0;
};

// Takes three floats a pixel, row by row; sRGB display values 0..1.
FlipMap ldr_flip(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height);

// Takes three floats a pixel, linear radiance; returns the largest LDR-FLIP over automatic exposures, with ACES tone
// mapping.
FlipMap hdr_flip(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height);

}  // namespace sideray::lab
