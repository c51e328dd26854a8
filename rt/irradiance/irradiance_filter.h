// Takes the noise out of the light in a picture's cells, and spreads it over the pixels. An edge-avoiding wavelet filter
// (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering") over cells of one
// plane, which reads no farther than the light may be taken for equal: in proportion to the harmonic mean of the distances of
// what throws it (Ward et al. 1988, "A Ray Tracing Solution for Diffuse Interreflection"), and not behind a wall. Keeps its memory from frame to frame.
#pragma once

#include <span>
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
  // The cells of a picture, walls between those of the frame before, which are found anew, and fill_depths() of its pixels.
  struct Input {
    const IrradianceRequest& request;
    const IrradianceCells& cells;
    CellWalls& walls;
    std::span<const float> depths;
  };
  // Writes rows of the image's pixels from the cells: the same bits whichever rows are written together, for any thread count.
  void apply(const Input& input, PixelRows rows, TracedScene& scene, IrradianceImage& image);

 private:
  void begin(const IrradianceCells& cells, CellRows rows);
  void smooth(const Input& input, size_t number, CellRows rows, Executor& executor);
  void take_mean_sky(const IrradianceCells& cells, CellRows rows);
  void pass(const Input& input, size_t number, CellRows rows, Executor& executor);
  float nearby(const IrradianceCells& cells, size_t own, size_t other, float distance) const;
  void look_for_walls(const Input& input, size_t number, CellRows rows, const Intersector& intersector, Executor& executor);
  void spread(const Input& input, PixelRows rows, const Intersector& intersector, Executor& executor, IrradianceImage& image);

  std::vector<glm::vec4> light_, next_;          // w: weight
  std::vector<glm::vec2> smooth_, next_smooth_;  // CellLight's nearness and open
  std::vector<PixelRow> rows_;  // of each thread
};

}  // namespace sideray::rt
