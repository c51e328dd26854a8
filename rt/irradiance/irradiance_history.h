// Accumulates the samples of a sequence's frames: a cell goes on with the mean of its surface, wherever the camera
// moves. Under a budget a frame finds new places for the cells of the rows of tiles that it traces, and reprojects the
// other cells. A frame without time for a row leaves the cells alone and reprojects only the image. One object per
// sequence. One thread begins and ends a frame; any thread may look back.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
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
  // Returns the frame's depths, as fill_depths() does.
  std::span<const float> depths() const { return trail().depths(); }
  // Scratch memory of a thread that calls look_back().
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> cells;
    std::vector<uint8_t> occluded;
  };
  // Writes the history of a tile's cells, whose places must be set: no samples if there is none, or if something stands
  // between the place and its previous one.
  void look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const Intersector& intersector, Scratch& scratch,
                 IrradianceCells& cells) const;

  // Returns adjacent rows of tiles to trace, as many as there is time for, which may be none: the least recently traced
  // row, in a new history the middle one, and its neighbours.
  TileRows next_rows(const WorkTime& work) const;
  // Returns how many rows there is time for; at least one unless is_over(work).
  uint32_t rows_in(const WorkTime& work) const;
  // Notes how long rows took.
  void took(double ms, uint32_t rows);
  // Reprojects the cells into this frame: each gets the place and light of the surface that it shows.
  void carry_cells(const IrradianceRequest& request, Executor& executor);
  // Reproject the previous image: carry_tile(), after begin_image(), fills a tile and counts its pixels.
  void begin_image(IrradianceImage& image);
  void carry_tile(uint32_t tile, IrradianceImage& image, Counters& counters) const;
  // Counts the rows of tiles that are filtered, once all tiles of a still view's position are traced.
  uint32_t filtered_rows = 0;

  // Ends a settled frame: the history stays unchanged.
  void keep();
  // Ends the frame: its cells become the history.
  void end();

 private:
  const PixelTrail& trail() const { return in_parts_ ? *shown_ : trail_; }
  void begin_cells(const IrradianceRequest& request, Executor& executor);
  bool carry(glm::uvec2 pixel);

  static constexpr uint32_t most_samples = 32;  // further samples change little

  bool settled_ = false, known_ = false, follows_ = false;
  bool in_parts_ = false;     // the image is reprojected; so are the cells if rows are traced
  bool cells_known_ = false, cells_begun_ = false, cells_follow_ = false;
  bool changed_ = false;      // something may have moved since the cells' frame
  float counted_ = 0.0f;      // a cell's history counts as at most so many samples
  bool stands_still_ = false;
  std::vector<uint8_t> turns_at_rest_;  // by tile: frames that traced it since something moved
  double row_ms_ = 0.0;  // time of a row of tiles; 0: not known yet
  std::shared_ptr<const model::Snapshot> posed_;
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  bool shadows_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail trail_, own_trail_;    // for the cells; for the image of frames that are traced in parts
  PixelTrail* shown_ = &own_trail_;
  uint64_t step_ = 0;               // of shown_ in the last frame
  bool carries_image_ = false;
  bool again_ = false;
  glm::dvec3 origin_{0.0};    // of the local space of the frame
  glm::dvec3 cells_origin_{0.0};  // the same for after_
  glm::vec3 moved_{0.0f};     // origin of before_ minus that of after_
  IrradianceCells before_, after_;  // before this frame, and after it
  CellWalls walls_;
  std::vector<uint16_t> light_then_;  // the previous frame's image
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
