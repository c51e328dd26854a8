// Draws the times of the last pictures by stage. Main thread.
#pragma once

#include <deque>
#include <memory>

#include "viewer/drawing/view.h"

namespace sideray::viewer {

class StageGraph {
 public:
  // Adds the newest picture of a side, unless it was added before.
  void add(size_t side, const std::shared_ptr<const Frame>& frame);
  void draw() const;

 private:
  struct Bar {
    std::array<double, 5> ms{};  // light, sky, other rays, filters, the rest
    double total = 0;
  };
  std::deque<Bar> bars_;
  std::array<std::shared_ptr<const Frame>, sides> last_;
};

}  // namespace sideray::viewer
