#include "model/wind.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "elementary/functions.h"
#include "model/failure.h"

namespace sideray::model {

Wind checked_wind(const sideray_wind_desc& d) {
  const auto check = [](const char* name, float value, bool good, const char* range) {
    if (!good || !std::isfinite(value)) fail(SIDERAY_INVALID_ARGUMENT, "wind {} is {}: give {}", name, value, range);
  };
  const float length = elementary::hypot(d.direction[0], d.direction[1], d.direction[2]);
  check("direction's length", length, std::abs(length - 1.0f) < 1e-3f, "a unit vector");
  for (const auto& [name, value] :
       {std::pair("amplitude", d.amplitude), std::pair("branch_amplitude", d.branch_amplitude),
        std::pair("leaf_amplitude", d.leaf_amplitude)})
    check(name, value, value >= 0.0f && value <= 1e6f, "0 to 1e6");
  for (const auto& [name, value] :
       {std::pair("frequency", d.frequency), std::pair("branch_frequency", d.branch_frequency),
        std::pair("leaf_frequency", d.leaf_frequency)})
    check(name, value, value >= 0.0f && value <= 1e3f, "0 to 1000 per second");
  check("height", d.height, d.height > 1e-6f && d.height <= 1e6f, "more than 0, at most 1e6");
  check("wavelength", d.wavelength, d.wavelength > 1e-6f && d.wavelength <= 1e6f, "more than 0, at most 1e6");
  return {d};
}

glm::vec3 wind_phase(const Wind& wind, double time_s, float instance_phase) {
  const sideray_wind_desc& d = wind.desc;
  const auto cycles = [&](float frequency) {
    const double x = double{frequency} * time_s + double{instance_phase};
    return static_cast<float>(x - std::floor(x));
  };
  return {cycles(d.frequency), cycles(d.branch_frequency), cycles(d.leaf_frequency)};
}

Bounds reached_in_wind(const Bounds& bounds, const Wind& wind) {
  if (bounds.empty()) return bounds;
  // Bounds sr_wind(): its factors are at most 2, and 4 where they are squared.
  const sideray_wind_desc& d = wind.desc;
  const float up = std::clamp(bounds.maximum.y / d.height, 0.0f, 2.0f);
  const float most = d.amplitude * up * up + 2.0f * d.branch_amplitude + 1.5f * up * d.leaf_amplitude;
  return {bounds.minimum - glm::vec3(most), bounds.maximum + glm::vec3(most)};
}

}  // namespace sideray::model
