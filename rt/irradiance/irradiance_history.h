// Accumulates samples over a sequence's frames: a cell continues the mean of its surface in the previous frame,
// wherever the camera has moved. Under a budget a frame recomputes some rows of tiles and reprojects the others. One
// object a sequence. One thread begins and ends a frame; any thread may call look_back().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/history/pixel_trail.h"
#include "rt/embree/intersector.h"
#include "rt/irradiance/cell_walls.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class IrradianceHistory {
 public:
  // Begins a frame. The history is reset if the frame does not continue the sequence, or lights, materials or
  // surroundings changed. A redrawn frame (`again`) has the history of the frame that it replaces.
  void begin(const IrradianceRequest& request, TracedScene& scene);
  // Resets the history.
  void forget() { known_ = false; }

  // Returns whether the frame needs no samples, because view and scene have been at rest until every cell had its
  // maximum of samples. The last image is then shown again.
  bool is_settled() const { return settled_; }
  // Returns the number of frames, this one included, since the history was reset.
  uint32_t frame() const { return number_; }
  // Returns the frame that last traced each tile, 0 = none.
  const std::vector<uint32_t>& turns() const { return turns_; }
  void traced(size_t tile);
  // Returns whether the frame is redrawn; then its cells do not enter the history.
  bool stands_for_last() const { return again_; }
  // Return the frame's cells, to be filled, and the walls of the previous frame until the filter updates them.
  IrradianceCells& cells() { return after_; }
  CellWalls& walls() { return walls_; }
  // Returns the frame's depths, from fill_depths().
  std::span<const float> depths() const { return trail_.depths(); }
  // Is the scratch memory of a thread that calls look_back().
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> cells;
    std::vector<uint8_t> occluded;
  };
  // Writes the history of a tile's cells, whose places must be set: no samples if there is none, or if something stands
  // between the place and its previous one.
  void look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const Intersector& intersector, Scratch& scratch,
                 IrradianceCells& cells) const;

  // Returns the adjacent rows of tiles to trace: the least recently traced, from the middle of the picture outward, and
  // as many as there is time for.
  TileRows next_rows(const WorkTime& work) const;
  // Returns how many rows there is time for, at least one.
  uint32_t rows_in(const WorkTime& work) const;
  // Notes how long rows took.
  void took(double ms, uint32_t rows);
  // Fills all cells with the history of their surfaces, places included.
  void carry_cells(Executor& executor);
  // Fills the rest of the image with the last image's light, where that showed the same surface.
  void carry_image(PixelRows but, Executor& executor, IrradianceImage& image);
  // For a position of a view at rest: number of rows of tiles that are filtered already.
  uint32_t filtered_rows = 0;

  // Ends a settled frame: the history stays unchanged.
  void keep();
  // Ends the frame: its cells become the history.
  void end();

 private:
  bool carry(glm::uvec2 pixel, uint32_t from);

  static constexpr uint32_t most_samples = 32;  // further samples change little

  bool settled_ = false, known_ = false, follows_ = false;
  float counted_ = 0.0f;      // the most samples that count
  bool stands_still_ = false;
  std::vector<uint8_t> turns_at_rest_;  // by tile: frames that traced it since something moved
  double row_ms_ = 0.0;  // time of a row of tiles; 0: not known yet
  std::shared_ptr<const model::Snapshot> posed_;
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  bool shadows_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail trail_;
  bool again_ = false;
  glm::dvec3 origin_{0.0};    // of the local space of after_
  glm::vec3 moved_{0.0f};     // origin of before_'s local space minus this frame's
  IrradianceCells before_, after_;  // the history before the frame, and after it
  CellWalls walls_;
  std::vector<uint16_t> light_then_;  // memory of carry_image()
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
