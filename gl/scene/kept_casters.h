// Remembers which instances each layer of the shadow maps holds, so that casters that have not moved are not drawn
// again. Plain memory without OpenGL; one thread at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "gl/scene/raster_scene.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Holds the casters of one shadow map layer, a bit each, by their places in the instance buffer.
class LayerCasters {
 public:
  // Sets the matrix that draws the layer from now on. Returns whether the layer's content stays valid; if not, all
  // casters are forgotten and the layer must be cleared.
  bool begin(const glm::mat4& clip_from_local, size_t places);
  void forget() { known_ = false; }

  // Returns whether the layer needs no draw of a place: it holds the instance already, or never shows it.
  bool is_settled(uint32_t place) const { return (settled(place / 64) >> (place % 64)) & 1; }
  // Return the same for all places from 64 * block to 64 * block + 63, and for `count` places from `first` on.
  bool is_block_settled(uint32_t block) const { return settled(block) == ~uint64_t{0}; }
  bool are_settled(uint32_t first, uint32_t count) const;
  void add_drawn(uint32_t place) { drawn_[place / 64] |= uint64_t{1} << (place % 64); }
  void add_outside(uint32_t place) { outside_[place / 64] |= uint64_t{1} << (place % 64); }
  // Call it where the caster at a place changed or moved: a layer that holds it is forgotten.
  void change(uint32_t place);

 private:
  uint64_t settled(size_t word) const { return drawn_[word] | outside_[word]; }

  bool known_ = false;
  glm::mat4 clip_from_local_{0.0f};
  std::vector<uint64_t> drawn_, outside_;
};

// Finds the instances that cast a different shadow than in the scene before.
class CasterChanges {
 public:
  // Holds the places of instances that changed; `all` where no comparison is possible, as without a scene before.
  struct Changes {
    bool all;
    std::vector<uint32_t> places;
  };
  Changes take(const RasterScene& scene);

 private:
  std::vector<uint32_t> compare(const model::Snapshot& now) const;
  std::vector<uint32_t> swaying(const RasterScene& scene) const;

  std::shared_ptr<const model::Snapshot> before_;
  std::vector<uint32_t> order_;  // of the instances of before_, by place
};

}  // namespace sideray::gl
