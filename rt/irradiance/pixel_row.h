// Gives a row of pixels the light of the cells about them: of those on their surface that nothing hides from them. Keeps its
// memory from row to row; one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/history/frame_camera.h"
#include "rt/irradiance/cell_walls.h"
#include "rt/irradiance/irradiance_cells.h"

namespace sideray::rt {

// What pixels are given: cells, the walls between them, and their light; w = 0: a cell has none.
struct CellsToSpread {
  const IrradianceCells& cells;
  const CellWalls& walls;
  const std::vector<glm::vec4>& lights;
};

class PixelRow {
 public:
  // Takes the row `y` of a picture by its depths, 0 = nothing is drawn.
  void find(const FrameCamera& camera, const CellsToSpread& from, const Intersector& intersector, const float* depths,
            uint32_t width, uint32_t y);
  // Returns the light of a pixel, and 1; 0 where there is none.
  glm::vec4 light(const CellsToSpread& from, uint32_t x) const;

 private:
  // Cells about a pixel that are of use to it.
  enum class Use { none, other_side, other_plane, same_plane };
  struct Pixel {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};  // of the cell that shows its plane; where there is none the way to the eye
    int rings = 0;           // of cells about it that count; 0: nothing is drawn
    bool has_plane = false;
    uint32_t hidden = 0;  // a bit for each of the cells about it that are behind something
  };
  // A ray from a pixel to a cell.
  struct Question {
    uint32_t pixel, hidden;
  };
  void find_plane(const CellsToSpread& from, uint32_t x, glm::vec3 to_eye);
  void ask(const CellsToSpread& from, uint32_t x, int ring);
  void answer(const Intersector& intersector);
  Use use_of(const CellsToSpread& from, const Pixel& pixel, size_t cell, uint32_t bit) const;
  bool has_light(const CellsToSpread& from, uint32_t x, int ring) const;

  uint32_t y_ = 0;
  std::vector<Pixel> pixels_;
  std::vector<Ray> rays_;
  std::vector<Question> questions_;
  std::vector<uint8_t> occluded_;
};

}  // namespace sideray::rt
