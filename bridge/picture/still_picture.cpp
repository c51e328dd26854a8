#include "bridge/picture/still_picture.h"

#include <algorithm>

namespace sideray::bridge {
namespace {

// An average over time counts for so many positions at most: it is blurred where things moved.
constexpr uint32_t most_averaged = 8;

}  // namespace

void StillPicture::restart(uint32_t seed) {
  pictures_ = summed_ = 0;
  waits_ = false;
  seed_ = seed;
  sum_.clear();
}

void StillPicture::begin_with(const std::vector<glm::vec4>& picture, uint32_t averaged) {
  first_ = picture;
  averaged_ = static_cast<float>(std::min(averaged, most_averaged));
}

std::vector<glm::vec4> StillPicture::wait() {
  waits_ = true;
  return shown();
}

std::vector<glm::vec4> StillPicture::add(const std::vector<glm::vec4>& drawn) {
  waits_ = false;
  if (summed_ == 0) {
    sum_ = drawn;
  } else {
    for (size_t i = 0; i < sum_.size(); ++i) sum_[i] += drawn[i];
  }
  ++summed_;
  if (summed_ == positions) first_ = {};
  return shown();
}

// The picture from before counts less with each position and no longer with the last, so that what is shown never jumps.
std::vector<glm::vec4> StillPicture::shown() const {
  if (summed_ == 0) return first_;
  std::vector<glm::vec4> mean = sum_;
  const float left = averaged_ * static_cast<float>(positions - summed_) / static_cast<float>(positions);
  const float all = static_cast<float>(summed_) + left;
  for (size_t i = 0; i < mean.size(); ++i) {
    if (left > 0.0f) mean[i] += left * first_[i];
    mean[i] /= all;
  }
  return mean;
}

}  // namespace sideray::bridge
