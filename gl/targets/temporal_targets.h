// Holds the pictures of temporal anti-aliasing: the one being made and the last one kept (the history). Nothing is
// allocated until its first use. The context must be current.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/targets/raster_targets.h"

namespace sideray::gl {

class TemporalTargets {
 public:
  explicit TemporalTargets(const Functions& gl) : gl_(gl) {}

  // Allocates for `targets`; history of another size is lost. Throws Failure (OUT_OF_MEMORY, UNSUPPORTED); then nothing
  // is allocated.
  void fit(const RasterTargets& targets);
  void release();

  // Makes the finished picture the history of the next one.
  void keep() { made_ = 1 - made_, has_past_ = static_cast<bool>(pictures_[0]), least_pictures_ = 1.0f; }
  void forget() { has_past_ = false; }
  // Replaces the history, which must exist, by a picture of its size that has the largest weight.
  void replace(const std::vector<glm::vec4>& picture);
  // Returns the least number of pictures that the history counts as.
  float least_pictures() const { return least_pictures_; }
  bool has_past() const { return has_past_; }
  uint32_t past_picture() const { return pictures_[1 - made_].id(); }
  uint32_t past_state() const { return states_[1 - made_].id(); }

  void bind(const RasterTargets& targets) const { targets.bind(framebuffers_[made_]); }
  void copy_to(const RasterTargets& targets) const;  // copies their colour

 private:
  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0, made_ = 0;
  bool has_past_ = false;
  float least_pictures_ = 1.0f;
  Texture pictures_[2], states_[2];
  Framebuffer framebuffers_[2];
};

}  // namespace sideray::gl
