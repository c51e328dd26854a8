// Holds the pictures that temporal anti-aliasing averages: the one being made and the last one kept. Nothing is
// allocated until it is used. The thread whose context is current calls it.
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

  // Allocates for `targets`; what was kept in another size is lost. Throws Failure (OUT_OF_MEMORY, UNSUPPORTED) and
  // then has none.
  void fit(const RasterTargets& targets);
  void release();

  // Makes the kept picture the past of the next one.
  void keep() { made_ = 1 - made_, has_past_ = static_cast<bool>(pictures_[0]), least_pictures_ = 1.0f; }
  void forget() { has_past_ = false; }
  // Replaces the kept picture, which has a past, by one of its size that counts for as many pictures as there can be.
  void replace(const std::vector<glm::vec4>& picture);
  // Returns for how many pictures the kept one counts at least.
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
