// Denoises the light in a picture's cells, and interpolates it for pixels. It is an edge-avoiding wavelet filter
// (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering") over cells
// of one plane. It shares light within a distance proportional to the harmonic mean of the distances to the light's
// origins (Ward et al. 1988, "A Ray Tracing Solution for Diffuse Interreflection"), and not across walls. It reuses its
// memory every frame.
#pragma once

#include <span>
#include <vector>

#include "rt/base/executor.h"
#include "rt/irradiance/cell_table.h"
#include "rt/irradiance/cell_walls.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/irradiance/pixel_row.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class IrradianceFilter {
 public:
  // The cells of a picture; walls of the previous frame, which are updated; and fill_depths() of its pixels.
  struct Input {
    const IrradianceRequest& request;
    const IrradianceCells& cells;
    CellWalls& walls;
    std::span<const float> depths;
  };
  // Writes rows of the image's pixels from the cells, with the same bits for any split into rows and any thread count.
  void apply(const Input& input, PixelRows rows, TracedScene& scene, IrradianceImage& image);

 private:
  template <typename Work>
  void for_blocks(CellRows rows, Executor& executor, const Work& work) const;
  void smooth(int32_t number, CellRows rows, const IrradianceKernels& kernels, Executor& executor);
  void pass(int32_t number, CellRows rows, const IrradianceKernels& kernels, Executor& executor);
  void take_mean_sky(const IrradianceCells& cells, CellRows rows, Executor& executor);
  void spread(const Input& input, PixelRows rows, TracedScene& scene, IrradianceImage& image);

  CellTable table_;
  std::vector<PixelRow> rows_;  // one a thread
};

}  // namespace sideray::rt
