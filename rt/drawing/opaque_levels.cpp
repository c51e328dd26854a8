#include "rt/drawing/opaque_levels.h"

#include <algorithm>

#include "elementary/functions.h"

namespace sideray::rt {

void OpaqueLevels::fill(uint32_t width, uint32_t height, const std::vector<glm::vec4>& picture, Executor& executor) {
  levels_.clear();
  levels_.push_back({width, height, std::vector<glm::vec3>(picture.begin(), picture.end())});
  while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(half_of(levels_.back(), executor));
  coarsest_ = elementary::log2(static_cast<float>(height));
}

// Samples the finer level bilinearly at the centre of each new texel, which for even sides is the mean of four.
OpaqueLevels::Level OpaqueLevels::half_of(const Level& fine, Executor& executor) {
  Level half{std::max(fine.width / 2, 1u), std::max(fine.height / 2, 1u), {}};
  half.texels.resize(size_t{half.width} * half.height);
  const glm::vec2 size(half.width, half.height);
  executor.run(half.height, [&](size_t y, uint32_t) {
    for (uint32_t x = 0; x < half.width; ++x)
      half.texels[y * half.width + x] = sample(fine, (glm::vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f) / size);
  });
  return half;
}

glm::vec3 OpaqueLevels::sample(const Level& level, glm::vec2 place) {
  const glm::ivec2 last(static_cast<int>(level.width) - 1, static_cast<int>(level.height) - 1);
  const glm::vec2 texel = place * glm::vec2(last + 1) - 0.5f;
  // A NaN reads a corner; positions outside read the border.
  const glm::vec2 at(texel.x > 0.0f ? std::min(texel.x, static_cast<float>(last.x)) : 0.0f,
                     texel.y > 0.0f ? std::min(texel.y, static_cast<float>(last.y)) : 0.0f);
  const glm::ivec2 low(at), high = glm::min(low + 1, last);
  const glm::vec2 share = at - glm::vec2(low);
  const auto color = [&](int x, int y) { return level.texels[static_cast<size_t>(y) * level.width + static_cast<size_t>(x)]; };
  return glm::mix(glm::mix(color(low.x, low.y), color(high.x, low.y), share.x),
                  glm::mix(color(low.x, high.y), color(high.x, high.y), share.x), share.y);
}

glm::vec3 OpaqueLevels::at(glm::vec2 place, float level) const {
  const auto last = static_cast<float>(levels_.size() - 1);
  const float bounded = level > 0.0f ? std::min(level, last) : 0.0f;
  const auto fine = static_cast<size_t>(bounded);
  const glm::vec3 color = sample(levels_[fine], place);
  const float share = bounded - static_cast<float>(fine);
  return share > 0.0f ? glm::mix(color, sample(levels_[fine + 1], place), share) : color;
}

}  // namespace sideray::rt
