#include "rt/drawing/temporal_average.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

// The shader's constants, explained there.
constexpr float infinitely_far = 1e30f, least_weight = 0.1f, deviations = 1.25f, same_distance = 0.9f;
constexpr float weight_of_brightness = 16.0f, as_many_as_can_be = 16.0f;

float luminance_of(glm::vec3 c) {
  return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

glm::vec3 to_ycocg(glm::vec3 c) {
  return {0.25f * c.r + 0.5f * c.g + 0.25f * c.b, 0.5f * c.r - 0.5f * c.b, -0.25f * c.r + 0.5f * c.g - 0.25f * c.b};
}

glm::vec3 to_rgb(glm::vec3 c) {
  return {c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z};
}

float bounded(float value, float most) {
  return value > 0.0f ? std::min(value, most) : 0.0f;
}

struct Neighbourhood {
  glm::vec3 mean, deviation;  // YCoCg
  float least_alpha, largest_alpha;
};

// Moves the colour toward the mean until it is inside the neighbourhood.
glm::vec3 clipped(glm::vec3 c, const Neighbourhood& n) {
  const glm::vec3 off = c - n.mean;
  const glm::vec3 units = glm::abs(off) / glm::max(deviations * n.deviation, glm::vec3(1e-6f + 1e-4f * std::abs(n.mean.x)));
  return n.mean + off / std::max({1.0f, units.x, units.y, units.z});
}

}  // namespace

class TemporalAverage::Pass {
 public:
  Pass(const AverageRequest& request, const OpaquePixels& pixels, const std::vector<glm::vec2>& motion,
       const std::vector<glm::vec4>& picture, const Kept* past, float least_pictures, Kept& made)
      : request_(request),
        pixels_(pixels),
        motion_(motion),
        picture_(picture),
        past_(past),
        least_pictures_(least_pictures),
        made_(made),
        size_(pixels.width, pixels.height) {}

  void average(glm::ivec2 pixel) {
    const size_t i = index(pixel);
    const glm::vec4 now = picture_at(pixel);
    made_.picture[i] = now;
    made_.state[i] = {distance_of(pixel, request_.distance_now), 1.0f};
    if (!past_) return;
    const glm::ivec2 mover = nearest_pixel(pixel);
    const glm::vec2 before = glm::vec2(pixel) + 0.5f - motion_[index(mover)];
    if (!(before.x >= 0.0f && before.y >= 0.0f && before.x < static_cast<float>(size_.x) && before.y < static_cast<float>(size_.y)))
      return;
    if (was_hidden(before, distance_of(mover, request_.distance_before))) return;
    const Neighbourhood n = neighbourhood_of(pixel);
    glm::vec4 past = history_at(before);
    past = glm::vec4(glm::max(to_rgb(clipped(to_ycocg(glm::vec3(past)), n)), glm::vec3(0.0f)),
                     glm::clamp(past.w, n.least_alpha, n.largest_alpha));
    const float pictures = std::max(past_->state[index(glm::ivec2(before))].y, least_pictures_) + 1.0f;
    const float weight = std::max(least_weight, 1.0f / pictures);
    const float scale = 1.0f / (weight_of_brightness * n.mean.x + 1e-6f);
    const float of_now = weight / (1.0f + luminance_of(glm::vec3(now)) * scale);
    const float of_past = (1.0f - weight) / (1.0f + luminance_of(glm::vec3(past)) * scale);
    const glm::vec3 mixed = (glm::vec3(now) * of_now + glm::vec3(past) * of_past) / (of_now + of_past);
    made_.picture[i] = glm::vec4(glm::min(mixed, glm::vec3(largest_half)), glm::mix(past.w, now.w, weight));
    made_.state[i].y = std::min(pictures, 1.0f / least_weight);
  }

 private:
  size_t index(glm::ivec2 p) const { return static_cast<size_t>(p.y) * pixels_.width + static_cast<size_t>(p.x); }
  glm::ivec2 inside(glm::ivec2 p) const { return glm::clamp(p, glm::ivec2(0), size_ - 1); }

  glm::vec4 picture_at(glm::ivec2 pixel) const {
    const glm::vec4 c = picture_[index(inside(pixel))];
    return {bounded(c.x, largest_half), bounded(c.y, largest_half), bounded(c.z, largest_half), bounded(c.w, 1.0f)};
  }

  // Returns the surface's nearness: larger is nearer, 0 is none.
  float nearness_at(glm::ivec2 pixel) const {
    const float depth = pixels_.depths[index(inside(pixel))];
    return request_.view.reversed_depth ? depth : 1.0f - depth;
  }

  float distance_of(glm::ivec2 pixel, const glm::dvec4& axis) const {
    const size_t i = index(pixel);
    if (pixels_.hits[i].instance == no_instance) return infinitely_far;
    const glm::dvec2 place = (glm::dvec2(pixel) + 0.5) * 2.0 / glm::dvec2(size_) - 1.0;
    const double depth = double{pixels_.depths[i]};
    const glm::dvec4 clip(place, request_.view.zero_to_one_depth ? depth : 2.0 * depth - 1.0, 1.0);
    const double part = glm::dot(request_.share, clip);
    return part > 0.0 ? static_cast<float>(std::min(glm::dot(axis, clip) / part, double{infinitely_far})) : infinitely_far;
  }

  // Returns the nearest of the pixel and its diagonal neighbours.
  glm::ivec2 nearest_pixel(glm::ivec2 pixel) const {
    glm::ivec2 nearest = pixel;
    for (const glm::ivec2 step : diagonals)
      if (nearness_at(pixel + step) > nearness_at(nearest)) nearest = pixel + step;
    return inside(nearest);
  }

  // Detects a disocclusion: everything in the history around the texel is clearly nearer than the pixel's surface.
  bool was_hidden(glm::vec2 texel, float distance) const {
    const glm::ivec2 at(texel);
    float deepest = past_->state[index(inside(at))].x;
    for (const glm::ivec2 step : diagonals) deepest = std::max(deepest, past_->state[index(inside(at + step))].x);
    return deepest < same_distance * distance;
  }

  // Samples the history bilinearly.
  glm::vec4 past_at(glm::vec2 texel) const {
    const glm::vec2 place = texel - 0.5f, corner = glm::floor(place), share = place - corner;
    const glm::ivec2 p(corner);
    const auto at = [&](int x, int y) { return past_->picture[index(inside(p + glm::ivec2(x, y)))]; };
    return glm::mix(glm::mix(at(0, 0), at(1, 0), share.x), glm::mix(at(0, 1), at(1, 1), share.x), share.y);
  }

  glm::vec4 history_at(glm::vec2 texel) const {
    const glm::vec2 middle = glm::floor(texel - 0.5f) + 0.5f, f = texel - middle;
    const glm::vec2 w0 = f * (-0.5f + f * (1.0f - 0.5f * f)), w1 = 1.0f + f * f * (-2.5f + 1.5f * f);
    const glm::vec2 w2 = f * (0.5f + f * (2.0f - 1.5f * f)), w3 = f * f * (-0.5f + 0.5f * f);
    const glm::vec2 w12 = w1 + w2, at0 = middle - 1.0f, at3 = middle + 2.0f, at12 = middle + w2 / w12;
    // The four corners have little weight and are left out.
    const glm::vec4 sum = past_at({at12.x, at0.y}) * (w12.x * w0.y) + past_at({at0.x, at12.y}) * (w0.x * w12.y) +
                          past_at(at12) * (w12.x * w12.y) + past_at({at3.x, at12.y}) * (w3.x * w12.y) +
                          past_at({at12.x, at3.y}) * (w12.x * w3.y);
    const float weight = w12.x * w0.y + w0.x * w12.y + w12.x * w12.y + w3.x * w12.y + w12.x * w3.y;
    return glm::max(sum / weight, glm::vec4(0.0f));
  }

  Neighbourhood neighbourhood_of(glm::ivec2 pixel) const {
    glm::vec3 sum(0.0f), squares(0.0f);
    float least = 1.0f, largest = 0.0f;
    for (int i = 0; i < 9; ++i) {
      const glm::vec4 picture = picture_at(pixel + glm::ivec2(i % 3 - 1, i / 3 - 1));
      const glm::vec3 c = to_ycocg(glm::vec3(picture));
      sum += c, squares += c * c;
      least = std::min(least, picture.w), largest = std::max(largest, picture.w);
    }
    const glm::vec3 mean = sum / 9.0f;
    return {mean, glm::sqrt(glm::max(squares / 9.0f - mean * mean, glm::vec3(0.0f))), least, largest};
  }

  static constexpr glm::ivec2 diagonals[] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};

  const AverageRequest& request_;
  const OpaquePixels& pixels_;
  const std::vector<glm::vec2>& motion_;
  const std::vector<glm::vec4>& picture_;
  const Kept* past_;
  float least_pictures_;
  Kept& made_;
  glm::ivec2 size_;
};

void TemporalAverage::average(const AverageRequest& request, const OpaquePixels& pixels,
                              const std::vector<glm::vec2>& motion, Executor& executor, std::vector<glm::vec4>& picture) {
  if (past_.width != pixels.width || past_.height != pixels.height) has_past_ = false;
  const bool follows = request.follows && has_past_;
  made_.width = pixels.width;
  made_.height = pixels.height;
  made_.picture.resize(picture.size());
  made_.state.resize(picture.size());
  Pass pass(request, pixels, motion, picture, follows ? &past_ : nullptr, least_pictures_, made_);
  executor.run(pixels.height, [&](size_t y, uint32_t) {
    for (uint32_t x = 0; x < pixels.width; ++x) pass.average({static_cast<int>(x), static_cast<int>(y)});
  });
  if (follows) picture = made_.picture;
}

void TemporalAverage::keep() {
  std::swap(made_, past_);
  has_past_ = !past_.picture.empty();
  least_pictures_ = 1.0f;
}

void TemporalAverage::replace(const std::vector<glm::vec4>& picture) {
  past_.picture = picture;
  for (glm::vec4& c : past_.picture) c = glm::min(c, glm::vec4(largest_half));  // no infinities: they would stay
                                                                                // forever
  least_pictures_ = as_many_as_can_be;
}

}  // namespace sideray::rt
