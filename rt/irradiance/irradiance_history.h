// Adds up the samples of a sequence's frames: a cell goes on with the mean that its surface had in the frame before, wherever
// the camera has gone. Under a budget a frame finds the places of some rows of tiles anew, and carries the others along; one
// without time for that leaves the cells where they were, and carries the image alone. One object a sequence. One thread begins
// and ends a frame; any may look back.
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
  // As fill_depths() finds them.
  std::span<const float> depths() const { return trail().depths(); }
  // Memory of a thread that looks back.
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> cells;
    std::vector<uint8_t> occluded;
  };
  // Writes the history of a tile's cells, whose places must be set: no samples if there is none, or if something stands
  // between the place and its previous one.
  void look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const Intersector& intersector, Scratch& scratch,
                 IrradianceCells& cells) const;

  // Returns the rows of tiles whose turn it is, next to each other: those that waited longest, from the middle of the picture
  // outward, and as many as there is time for, which may be none.
  TileRows next_rows(const WorkTime& work) const;
  // How many rows there is time for, at least one where one is to be traced in any case.
  uint32_t rows_in(const WorkTime& work) const;
  // Notes how long rows took.
  void took(double ms, uint32_t rows);
  // Puts the cells into this frame: fills them with what is known of the surface that they show, places included.
  void carry_cells(const IrradianceRequest& request, Executor& executor);
  // Fills tiles of the image with the last one's, where their surface was in that. Counts their pixels.
  void begin_image(IrradianceImage& image);
  void carry_tile(uint32_t tile, IrradianceImage& image, Counters& counters) const;
  // Rows of tiles of a position of a still view that are filtered, of those that are traced.
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
  bool in_parts_ = false;     // the image is carried, the cells only where rows are traced
  bool cells_known_ = false, cells_begun_ = false, cells_follow_ = false;
  bool changed_ = false;      // something may have moved since the cells' frame
  float counted_ = 0.0f;      // samples that are counted at most
  bool stands_still_ = false;
  std::vector<uint8_t> turns_at_rest_;  // by tile: frames that traced it since something moved
  double row_ms_ = 0.0;  // time of a row of tiles; 0: not known yet
  std::shared_ptr<const model::Snapshot> posed_;
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  bool shadows_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail trail_, own_trail_;    // of the cells; and of the image, where frames are traced in parts
  PixelTrail* shown_ = &own_trail_;
  uint64_t step_ = 0;               // of shown_ in the last frame
  bool carries_image_ = false;
  bool again_ = false;
  glm::dvec3 origin_{0.0};    // of the local space of the frame
  glm::dvec3 cells_origin_{0.0};  // of after_'s
  glm::vec3 moved_{0.0f};     // that of before_, less this frame's
  IrradianceCells before_, after_;  // what is known before the frame, and after it
  CellWalls walls_;
  std::vector<uint16_t> light_then_;  // the image of the frame before
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
