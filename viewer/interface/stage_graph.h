// Draws the times of the last pictures by stage. Main thread.
#pragma once

#include <deque>
#include <imgui.h>
#include <memory>

#include "viewer/drawing/view.h"

namespace sideray::viewer {

class StageGraph {
 public:
  // Adds the newest picture of a side, unless it was added before.
  void add(size_t side, const std::shared_ptr<const Frame>& frame);
  // Draws a bar for each picture, and the times of the newest picture of each shown side.
  void draw(size_t shown_sides) const;

 private:
  struct Bar {
    std::array<double, 5> ms{};  // light, sky, other rays, filters, the rest
    double total = 0;
  };
  void draw_bars() const;
  void draw_bar(const Bar& bar, double most_ms, ImVec2 foot, float width, float height) const;
  void draw_row(const char* name, ImU32 color, const std::array<double, sides>& ms, size_t shown_sides) const;

  std::deque<Bar> bars_;
  std::array<Bar, sides> newest_;
  std::array<std::shared_ptr<const Frame>, sides> last_;
};

}  // namespace sideray::viewer
