// Interpolates the light of cells for a row of pixels, from cells on their surface that nothing occludes. Most pixels
// use the cells around without a test, in lanes. It reuses its memory for every row; one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/history/frame_camera.h"
#include "rt/irradiance/cell_table.h"
#include "rt/irradiance/cell_walls.h"
#include "rt/irradiance/irradiance_cells.h"

namespace sideray::rt {

// Refers to the inputs: cells, walls near them, and their light.
struct CellsToSpread {
  const IrradianceCells& cells;
  const CellWalls& walls;
  const CellTable& table;
};

class PixelRow {
 public:
  // Processes row `y` of a picture, given its depths, 0 = no surface.
  void find(const FrameCamera& camera, const CellsToSpread& from, const Intersector& intersector, const float* depths,
            uint32_t width, uint32_t y);
  // Returns the light of a pixel, and 1; 0 without light.
  glm::vec4 light(uint32_t x) const { return lights_[x]; }

 private:
  // How a cell around a pixel can be used.
  enum class Use { none, other_side, other_plane, same_plane };
  struct Pixel {
    uint32_t x;
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};  // of the cell that shows its plane; otherwise the direction to the eye
    int rings = 1;           // of cells around it that are used
    bool has_plane = false;
    bool by_own = false;  // its own cell shows its plane and is not occluded
    uint32_t hidden = 0;  // one bit for each cell around it that is occluded
  };
  // Describes a ray from one of pixels_ to a cell.
  struct Question {
    uint32_t pixel, hidden;
  };
  // Holds the pixels of every second column, starting with column 0 or 1.
  struct HalfRow {
    std::vector<float> position[3], depth, light[3];
    PixelColumns at(size_t cell);
  };
  void locate(const FrameCamera& camera, const float* depths, uint32_t width);
  void spread(const CellsToSpread& from, const IrradianceKernels& kernels, uint32_t width);
  void find_plane(const CellsToSpread& from, Pixel& pixel, glm::vec3 to_eye);
  bool ask_own(const CellsToSpread& from, uint32_t pixel);
  void ask_around(const CellsToSpread& from, uint32_t pixel, int ring);
  void ask(const CellsToSpread& from, uint32_t pixel, size_t cell, uint32_t bit);
  void hide_behind_walls(const CellsToSpread& from, Pixel& pixel) const;
  void answer(const Intersector& intersector);
  Use use_of(const CellsToSpread& from, const Pixel& pixel, size_t cell, uint32_t bit) const;
  bool has_light(const CellsToSpread& from, const Pixel& pixel, int ring) const;
  glm::vec4 mean_light(const CellsToSpread& from, const Pixel& pixel) const;

  uint32_t y_ = 0;
  HalfRow halves_[2];
  std::vector<glm::vec4> lights_;
  std::vector<Pixel> pixels_;  // pixels that need rays
  std::vector<Ray> rays_;
  std::vector<Question> questions_;
  std::vector<uint8_t> occluded_;
};

}  // namespace sideray::rt
