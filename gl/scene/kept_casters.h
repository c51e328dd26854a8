// Remembers which instances each layer of the shadow maps holds, so that what has not moved is not drawn again. Plain
// memory without OpenGL; one thread at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "gl/scene/raster_scene.h"
#include "model/snapshot.h"

namespace sideray::gl {

// The casters of one layer, a bit each, by their places in the instance buffer.
class LayerCasters {
 public:
  // The layer is drawn by this matrix from now on. Returns whether what it holds stays, with all that is known of its
  // casters; otherwise it is to be cleared.
  bool begin(const glm::mat4& clip_from_local, size_t places);
  void forget() { known_ = false; }

  // Whether nothing more is to be done for a place: the layer holds it, or never shows it.
  bool is_settled(uint32_t place) const { return (settled(place / 64) >> (place % 64)) & 1; }
  // The same for all places from 64 * block to 64 * block + 63, and for `count` places from `first` on.
  bool is_block_settled(uint32_t block) const { return settled(block) == ~uint64_t{0}; }
  bool are_settled(uint32_t first, uint32_t count) const;
  void add_drawn(uint32_t place) { drawn_[place / 64] |= uint64_t{1} << (place % 64); }
  void add_outside(uint32_t place) { outside_[place / 64] |= uint64_t{1} << (place % 64); }
  // A caster is another one now, or elsewhere: what holds it is forgotten.
  void change(uint32_t place);

 private:
  uint64_t settled(size_t word) const { return drawn_[word] | outside_[word]; }

  bool known_ = false;
  glm::mat4 clip_from_local_{0.0f};
  std::vector<uint64_t> drawn_, outside_;
};

// Finds the instances that cast another shadow than in the scene before.
class CasterChanges {
 public:
  // Returns the places of instances that changed, or that nothing is known of any (`all`), as where there was no scene
  // before.
  struct Changes {
    bool all;
    std::vector<uint32_t> places;
  };
  Changes take(const RasterScene& scene);

 private:
  std::vector<uint32_t> compare(const model::Snapshot& now) const;
  std::vector<uint32_t> swaying(const RasterScene& scene) const;

  std::shared_ptr<const model::Snapshot> before_;
  std::vector<uint32_t> order_;  // its instances, by place
};

}  // namespace sideray::gl
