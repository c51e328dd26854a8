// How much worse a tree of boxes has become whose triangles moved since it was built. One thread at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

// The measure is the surface area heuristic on boxes of its own: triangles in the order of a space-filling curve at the
// pose that was built, grouped by fours level upon level. The sum of the boxes' areas over that of the whole is how
// many of them a ray meets; refitting keeps the groups, as it keeps Embree's tree, and their boxes grow.
class PoseQuality {
 public:
  // At this share of the built pose's cost and above, a refit tree is rebuilt.
  static constexpr double worst_growth = 1.3;

  // Remembers the mesh as built.
  void build(const model::Mesh& mesh);
  // Cost of the mesh as it is over its cost as built; infinite before the first build().
  double growth(const model::Mesh& mesh);

 private:
  double cost(const model::Mesh& mesh);

  std::vector<uint32_t> order_;
  std::vector<model::Bounds> boxes_;
  double built_ = 0.0;
};

}  // namespace sideray::rt
