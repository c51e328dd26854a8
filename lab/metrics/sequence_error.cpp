#include "lab/metrics/sequence_error.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace sideray::lab {
namespace {

bool is_finite(const scenes::Image& image) {
  return std::all_of(image.planes.begin(), image.planes.end(), [](const scenes::Plane& plane) {
    return std::all_of(plane.values.begin(), plane.values.end(), [](float v) { return std::isfinite(v); });
  });
}

}  // namespace

void SequenceError::add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion) {
  const Metrics metrics = compare(test, reference, display_).metrics;
  nonfinite_ += metrics.nonfinite;
  for (const std::string& name : metric_names()) {
    const std::optional<double> value = metric(metrics, name);
    if (value && (frames_ == 0 || sums_.contains(name)))
      sums_[name] += *value;
    else
      sums_.erase(name);
  }
  const uint32_t frame = frames_++;
  if (nonfinite_ > 0) return;
  last_ = test;
  if (frame < first_looked_at_) return;
  flicker_.add(test, reference);
  warp_.add(test, reference, motion);
}

void SequenceError::add_at_rest(const scenes::Image& picture) {
  if (nonfinite_ > 0) return;
  if (!is_finite(picture)) {
    ++nonfinite_;
    return;
  }
  if (!settle_) {
    settle_.emplace(display_);
    settle_->add(last_);
  }
  settle_->add(picture);
}

nlohmann::ordered_json SequenceError::result() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const std::string& name : metric_names())
    if (sums_.contains(name)) json[name] = sums_.at(name) / frames_;
  json["nonfinite"] = nonfinite_;
  if (nonfinite_ > 0 || frames_ < 2) return json;
  const Flicker flicker = flicker_.result();
  const Warped warped = warp_.result();
  const Settling settling = settle_ ? settle_->result() : Settling{};
  json["flicker"] = flicker.excess_energy();
  json["flicker_of_error"] = flicker.error_energy;
  if (warped.share > 0) json["warped_difference"] = warped.excess();
  json["ghost"] = settling.ghost;
  json["ghost_half_life"] = settling.half_life;
  json["settle_time"] = settling.settle_time;
  return json;
}

}  // namespace sideray::lab
