// Measures how much worse a bounding volume hierarchy has become since its triangles moved. One thread at a time may
// call it.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

// It evaluates the surface area heuristic on its own boxes: triangles in the order of a space-filling curve at the
// built pose, grouped by fours level by level. The sum of the boxes' areas over the area of the whole is the number of
// boxes that a ray hits. Refitting keeps the groups, as it keeps Embree's tree, and their boxes grow.
class PoseQuality {
 public:
  // A refit tree is rebuilt when its cost over that of the built pose reaches this value.
  static constexpr double worst_growth = 1.3;

  // Stores the mesh's cost as built.
  void build(const model::Mesh& mesh);
  // Returns the mesh's cost over its cost as built; infinite before the first build().
  double growth(const model::Mesh& mesh);

 private:
  double cost(const model::Mesh& mesh);

  std::vector<uint32_t> order_;
  std::vector<model::Bounds> boxes_;
  double built_ = 0.0;
};

}  // namespace sideray::rt
