// Composites a frame's surfaces into the image, after clearing the tiles of the previous frame. One thread calls
// begin_composite; the sinks of different chunks write different texels and may run at the same time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/composite/composite_image.h"
#include "rt/layers/layer_request.h"
#include "rt/layers/layer_tracer.h"
#include "rt/refraction/refraction_tracer.h"

namespace sideray::rt {

// Resizes the image, clears the tiles traced in the last frame and those about to be traced, and marks both as dirty.
void begin_composite(const LayerRequest& request, const std::vector<uint8_t>& tiles, Executor& executor,
                     CompositeImage& image);

class CompositeSink final : public LayerSink {
 public:
  // Accumulates the surfaces of one pixel of a chunk.
  struct Pixel {
    glm::vec3 radiance, half_difference, transmittance;
  };
  // exact: stores the mean of each radiance's two estimates and half of their difference, and continues to the last
  // visible surface.
  CompositeSink(CompositeImage& image, std::vector<Pixel>& scratch, bool exact)
      : image_(image), pixels_(scratch), exact_(exact) {}
  void begin(std::span<const PixelRequest> pixels) override;
  bool meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) override;
  void add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) override;
  bool finished(uint32_t pixel) const override;
  void end(std::span<const PixelRequest> pixels) override;

 private:
  CompositeImage& image_;
  std::vector<Pixel>& pixels_;
  bool exact_;
};

// Stores the light of refracted rays. The alpha of radiance is 1 minus the transmittance to the surroundings, which the
// radiance includes. exact: as in CompositeSink.
void store_refracted(std::span<const PixelRequest> pixels, const std::vector<RefractedPixel>& seen, bool exact,
                     CompositeImage& image);

}  // namespace sideray::rt
