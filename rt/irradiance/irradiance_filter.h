// Takes the noise out of the light in a picture's cells, and spreads it over the pixels. An edge-avoiding wavelet filter
// (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering") over cells of one
// plane, which reads no farther than the light may be taken for equal: in proportion to the harmonic mean of the distances of
// what throws it (Ward et al. 1988, "A Ray Tracing Solution for Diffuse Interreflection"). So it ends before the next wall,
// however thin. Keeps its memory from frame to frame.
#pragma once

#include <vector>

#include "rt/base/executor.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_request.h"

namespace sideray::rt {

class IrradianceFilter {
 public:
  // Writes the image from the cells. Same bits for any thread count.
  void apply(const IrradianceRequest& request, const IrradianceCells& cells, Executor& executor, IrradianceImage& image);

 private:
  void begin(const IrradianceCells& cells);
  void smooth(const IrradianceCells& cells, uint32_t step, Executor& executor);
  void take_mean_sky(const IrradianceCells& cells);
  void pass(const IrradianceCells& cells, uint32_t step, Executor& executor);
  void spread(const IrradianceRequest& request, const IrradianceCells& cells, Executor& executor, IrradianceImage& image);

  std::vector<glm::vec4> light_, next_;          // w: weight
  std::vector<glm::vec2> smooth_, next_smooth_;  // CellLight's nearness and open
  std::vector<float> depths_;
};

}  // namespace sideray::rt
