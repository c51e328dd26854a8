// Distorts the picture behind translucent surfaces in screen space, by rays, with the same result as
// gl/passes/distortion_pass.cpp. Several threads may work on different pixels.
#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "rt/base/view_rays.h"
#include "rt/layers/layer_tracer.h"

namespace sideray::rt {

// Holds what is behind a pixel's translucent surfaces, in two estimates.
struct OpaqueTexel {
  glm::vec3 radiance[2];
  float coverage;  // 0 = sky
  float depth;     // as ViewRays::depth; infinite for the sky
};

// Holds how far the translucent surfaces of a pixel shift the picture behind them.
struct PixelOffset {
  glm::vec2 heights{0.0f};                                 // in heights of the picture: to the right, up
  float nearest = std::numeric_limits<float>::infinity();  // depth of the nearest surface that distorts
};

// Returns whether anything in the scene distorts.
bool distorts(const model::Snapshot& snapshot);

// Adds up the offsets of a chunk's pixels; requests no shading.
class DistortionSink final : public LayerSink {
 public:
  // `offsets` has one entry for each texel of a picture that is `width` wide.
  DistortionSink(const ViewRays& view, uint32_t width, std::vector<PixelOffset>& offsets)
      : view_(view), width_(width), offsets_(offsets) {}
  void begin(std::span<const PixelRequest> pixels) override;
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t, uint32_t, const Hit&, const glm::vec3*, glm::vec3) override {}
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest>) override {}

 private:
  PixelOffset& offset_of(const PixelRequest& p) const { return offsets_[size_t{p.y} * width_ + p.x]; }

  const ViewRays& view_;
  uint32_t width_;
  std::vector<PixelOffset>& offsets_;
  std::span<const PixelRequest> pixels_;
};

// Returns the distorted texel of pixel (x, y) of a picture that is `width` wide and starts with its bottom row.
OpaqueTexel distorted(const std::vector<OpaqueTexel>& picture, uint32_t width, uint32_t x, uint32_t y,
                      const PixelOffset& offset);

}  // namespace sideray::rt
