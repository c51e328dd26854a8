// Adds up the samples of a sequence's frames: a cell goes on with the mean that its surface had in the frame before, wherever
// the camera has gone. One object a sequence. One thread begins and ends a frame; any may look back.
#pragma once

#include <cstdint>
#include <memory>
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
  // Learns of a frame. One that follows none, or another light, material or surrounding, leaves nothing. One that stands for the
  // last one (`again`) knows what that knew.
  void begin(const IrradianceRequest& request, TracedScene& scene);
  // Nothing is known any longer.
  void forget() { known_ = false; }

  // Returns whether the frame adds nothing: the view has stood still, with nothing that moves, until each cell had all samples
  // that are counted. What was shown is what is to be shown.
  bool is_settled() const { return settled_; }
  // Returns how many frames the sequence has, this one included, since something was known last.
  uint32_t frame() const { return number_; }
  // In which frame each tile was traced last, 0 = never.
  const std::vector<uint32_t>& turns() const { return turns_; }
  void traced(size_t tile) { turns_[tile] = number_; }
  // Memory of a thread that looks back.
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> cells;
    std::vector<uint8_t> occluded;
  };
  // Writes what is known of the cells of a tile whose places are known: no samples where nothing is, or where something stands
  // between the place and the one that is known. `walls`: of the frame before.
  void look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const CellWalls& walls, const Intersector& intersector,
                 Scratch& scratch, IrradianceCells& cells) const;
  // The frame is settled: what was known before is known after it.
  void keep();
  // Learns what is known after the frame, and takes the cells: what it leaves is of no use.
  void end(IrradianceCells& cells);

 private:
  static constexpr uint32_t most_samples = 32;  // more say little more

  bool settled_ = false, known_ = false, follows_ = false;
  float counted_ = 0.0f;      // samples that are counted at most
  uint32_t stood_still_ = 0;  // frames in a row that were traced as a whole and in which nothing moved
  std::shared_ptr<const model::Snapshot> posed_;
  uint32_t width_ = 0, height_ = 0, number_ = 0;
  bool shadows_ = false;
  std::shared_ptr<const model::Snapshot> committed_;
  PixelTrail trail_;
  bool again_ = false;
  glm::dvec3 origin_{0.0};    // of the local space of after_
  glm::vec3 moved_{0.0f};     // that of before_, less this frame's
  IrradianceCells before_, after_;  // what is known before the frame, and after it
  std::vector<uint32_t> turns_;
};

}  // namespace sideray::rt
