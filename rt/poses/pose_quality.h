// Measures how much worse a tree of boxes has become since its triangles moved. One thread at a time may call it.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"

namespace sideray::rt {

// The measure is the surface area heuristic on boxes of its own: triangles in the order of a space-filling curve at the
// pose that was built, grouped by fours level upon level. The sum of the boxes' areas over that of the whole is how
// many of them a ray hits; refitting keeps the groups, as it keeps Embree's tree, and their boxes grow.
class PoseQuality {
 public:
  // A refit tree is rebuilt where its cost reaches this share of the built pose's.
  static constexpr double worst_growth = 1.3;

  // Remembers the mesh as built.
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
