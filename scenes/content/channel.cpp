#include "scenes/content/channel.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "scenes/content/rotation.h"

namespace sideray::scenes {
namespace {

// Returns up to four numbers of an element, from `first` on.
glm::dvec4 value_at(const Channel& channel, size_t element, size_t first) {
  const size_t components = components_of(channel);
  glm::dvec4 value(0.0);
  for (size_t c = first; c < std::min(components, first + 4); ++c)
    value[static_cast<int>(c - first)] = double{channel.values[element * components + c]};
  return value;
}

// Evaluates a Hermite spline whose tangents are per second (glTF 2.0, appendix C.5).
glm::dvec4 cubic(const Channel& channel, size_t key, double t, double duration, size_t first) {
  const glm::dvec4 v0 = value_at(channel, 3 * key + 1, first), v1 = value_at(channel, 3 * key + 4, first);
  const glm::dvec4 out0 = value_at(channel, 3 * key + 2, first), in1 = value_at(channel, 3 * key + 3, first);
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * v0 + duration * (t3 - 2 * t2 + t) * out0 + (3 * t2 - 2 * t3) * v1 +
         duration * (t3 - t2) * in1;
}

glm::dvec4 unit(const glm::dvec4& v) {
  const double length = glm::length(v);
  return length > 1e-6 ? v / length : glm::dvec4(0, 0, 0, 1);
}

double looped(double time_s, double period_s) {
  if (!(period_s > 0.0)) return time_s;
  return time_s - period_s * std::floor(time_s / period_s);
}

glm::dvec4 interpolate(const Channel& channel, double time, size_t first) {
  const std::vector<float>& times = channel.times;
  const size_t stored = channel.interpolation == Interpolation::cubic ? 3 : 1, middle = stored / 2;
  const auto next =
      std::upper_bound(times.begin(), times.end(), time, [](double t, float key) { return t < double{key}; });
  if (next == times.begin()) return value_at(channel, middle, first);
  if (next == times.end()) return value_at(channel, (times.size() - 1) * stored + middle, first);
  const auto key = static_cast<size_t>(next - times.begin()) - 1;
  if (channel.interpolation == Interpolation::step) return value_at(channel, key, first);
  const double start = double{times[key]}, duration = double{times[key + 1]} - start, t = (time - start) / duration;
  if (channel.interpolation == Interpolation::cubic) return cubic(channel, key, t, duration, first);
  const glm::dvec4 from = value_at(channel, key, first), to = value_at(channel, key + 1, first);
  if (channel.property == Property::rotation) return slerp(unit(from), unit(to), t);
  return glm::mix(from, to, t);
}

}  // namespace

size_t components_of(const Channel& channel) {
  switch (channel.property) {
    case Property::weights:
    case Property::value:
      return channel.targets;
    case Property::rotation:
      return 4;
    case Property::visible:
      return 1;
    case Property::translation:
    case Property::scale:
      break;
  }
  return 3;
}

glm::dvec4 sample(const Channel& channel, double time_s) {
  const glm::dvec4 value = interpolate(channel, looped(time_s, channel.period_s), 0);
  return channel.property == Property::rotation ? unit(value) : value;
}

std::vector<double> sample_weights(const Channel& channel, double time_s) {
  std::vector<double> weights(channel.targets);
  for (size_t first = 0; first < weights.size(); first += 4) {
    const glm::dvec4 value = interpolate(channel, looped(time_s, channel.period_s), first);
    const size_t end = std::min(weights.size(), first + 4);
    for (size_t c = first; c < end; ++c) weights[c] = value[static_cast<int>(c - first)];
  }
  return weights;
}

}  // namespace sideray::scenes
