// Looks up the light that arrives at surfaces which the picture shows: what rays meet behind glass is mostly what the
// opaque pixels there show, and their light is known. Immutable; any thread may use it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>

#include "rt/base/view_rays.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

// Refers to the light that arrives at a frame's opaque pixels. Row 0 is the bottom row.
struct PixelLight {
  std::span<const uint16_t> thrown;  // as IrradianceImage::light
  std::span<const uint8_t> open;     // as OcclusionMasks::open
  // These are OcclusionMasks::answers. A pixel's `open` is known if it has the bit `answer_of_open`; other pixels look open.
  // Where `answers` is empty, all pixels are known.
  std::span<const uint8_t> answers = {};
  uint8_t answer_of_open = 0;
};

class SeenLight {
 public:
  // The caller keeps the images of `light` and `depth`, of width x height pixels, alive.
  SeenLight(const TraceView& view, uint32_t width, uint32_t height, const DepthImage& depth, const PixelLight& light);
  // Returns the light at the point; nothing unless its pixel shows it.
  std::optional<ArrivingLight> at(const PointAround& point) const;

 private:
  bool shows(uint32_t x, uint32_t y, const PointAround& point) const;

  ViewRays rays_;
  glm::dmat4 clip_from_local_;
  uint32_t width_, height_;
  DepthImage depth_;
  PixelLight light_;
};

}  // namespace sideray::rt
