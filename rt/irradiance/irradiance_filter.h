// Takes the noise out of the light in a picture's cells, and spreads it over the pixels. An edge-avoiding wavelet filter
// (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering") over cells of one
// plane, which reads no farther than the light may be taken for equal: in proportion to the harmonic mean of the distances of
// what throws it (Ward et al. 1988, "A Ray Tracing Solution for Diffuse Interreflection"), and not behind a wall. Keeps its memory from frame to frame.
#pragma once

#include <vector>

#include "rt/base/executor.h"
#include "rt/irradiance/cell_walls.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/irradiance/pixel_row.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class IrradianceFilter {
 public:
  // Writes the image from the cells. Same bits for any thread count.
  void apply(const IrradianceRequest& request, const IrradianceCells& cells, TracedScene& scene, IrradianceImage& image);
  // Of the frame that was filtered last.
  const CellWalls& walls() const { return walls_; }

 private:
  void begin(const IrradianceCells& cells);
  void smooth(const IrradianceCells& cells, size_t number, Executor& executor);
  void take_mean_sky(const IrradianceCells& cells);
  void pass(const IrradianceCells& cells, size_t number, Executor& executor);
  float nearby(const IrradianceCells& cells, size_t own, size_t other, float distance) const;
  void look_for_walls(const IrradianceCells& cells, size_t number, const Intersector& intersector, Executor& executor);
  void spread(const IrradianceRequest& request, const IrradianceCells& cells, const Intersector& intersector, Executor& executor,
              IrradianceImage& image);

  std::vector<glm::vec4> light_, next_;          // w: weight
  std::vector<glm::vec2> smooth_, next_smooth_;  // CellLight's nearness and open
  CellWalls walls_;
  std::vector<float> depths_;
  std::vector<PixelRow> rows_;  // of each thread
};

}  // namespace sideray::rt
