#include "lab/metrics/temporal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sideray/sideray.hpp>

namespace sideray::lab {
namespace {

constexpr double same_depth = 0.1;  // as a share of the distance

const scenes::Plane& plane_of(const scenes::Image& image, const char* name) {
  const scenes::Plane* plane = image.find(name);
  if (plane) return *plane;
  throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("motion of a sequence: no channel {}; draw it with --aov", name));
}

// Holds the four pixels around a point, with their bilinear weights.
struct Taps {
  size_t pixels[4] = {};
  double weights[4] = {};
  bool is_inside = false;
};

Taps taps_at(double x, double y, uint32_t width, uint32_t height) {
  Taps taps;
  const double left = std::floor(x), top = std::floor(y);
  const double right = x - left, down = y - top;  // shares
  taps.is_inside = true;
  for (size_t i = 0; i < 4; ++i) {
    const double u = left + (i & 1 ? 1.0 : 0.0), v = top + (i & 2 ? 1.0 : 0.0);
    taps.weights[i] = (i & 1 ? right : 1 - right) * (i & 2 ? down : 1 - down);
    if (taps.weights[i] == 0.0) continue;
    // Written so that NaN motion also counts as outside.
    taps.is_inside = taps.is_inside && u >= 0 && v >= 0 && u < width && v < height;
    if (taps.is_inside) taps.pixels[i] = static_cast<size_t>(v) * width + static_cast<size_t>(u);
  }
  return taps;
}

bool is_near(float a, float b) {
  return a == b || std::abs(double{a} - double{b}) <= same_depth * double{std::min(a, b)};
}

double looked_up(const std::vector<float>& values, const Taps& taps, size_t channel) {
  double sum = 0;
  for (size_t i = 0; i < 4; ++i)
    if (taps.weights[i] != 0.0) sum += taps.weights[i] * double{values[3 * taps.pixels[i] + channel]};
  return sum;
}

double square(double x) {
  return x * x;
}

// Returns the fractional frame at which a curve that falls exponentially from `above` to `below` reaches `level`.
double crossing(double frame, double above, double below, double level) {
  if (below <= 0) return frame - 1 + (above - level) / above;
  return frame - 1 + std::log(above / level) / std::log(above / below);
}

}  // namespace

void WarpMeter::add(const scenes::Image& test, const scenes::Image& reference, const scenes::Image& motion) {
  std::vector<float> now = scenes::display_values(test, display_.exposure_ev, display_.tonemap);
  std::vector<float> wanted = scenes::display_values(reference, display_.exposure_ev, display_.tonemap);
  const scenes::Plane &across = plane_of(motion, "motion.X"), &down = plane_of(motion, "motion.Y");
  const scenes::Plane &distance = plane_of(motion, "Z"), &surface = plane_of(motion, "id.surface");
  const size_t pixels = size_t{motion.width} * motion.height;
  if (now.size() != 3 * pixels || wanted.size() != now.size() || (frames_ > 0 && now.size() != test_.size()))
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("frame {} of a sequence: its size differs from the others'; compare equal sizes", frames_));
  for (size_t p = 0; frames_ > 0 && p < pixels; ++p) {
    const Taps taps =
        taps_at(static_cast<double>(p % motion.width) - double{across.values[p]},
                static_cast<double>(p / motion.width) - double{down.values[p]}, motion.width, motion.height);
    bool was_seen = taps.is_inside;
    for (size_t i = 0; i < 4 && was_seen; ++i)
      was_seen = taps.weights[i] == 0.0 || (surface_[taps.pixels[i]] == surface.uint_values[p] &&
                                            is_near(distance_[taps.pixels[i]], distance.values[p]));
    ++pixels_;
    if (!was_seen) continue;
    ++compared_;
    for (size_t c = 0; c < 3; ++c) {
      test_squares_ += square(looked_up(test_, taps, c) - double{now[3 * p + c]});
      reference_squares_ += square(looked_up(reference_, taps, c) - double{wanted[3 * p + c]});
    }
  }
  test_ = std::move(now), reference_ = std::move(wanted);
  distance_ = distance.values, surface_ = surface.uint_values;
  ++frames_;
}

Warped WarpMeter::result() const {
  Warped warped;
  if (compared_ == 0) return warped;
  const double values = 3.0 * static_cast<double>(compared_);
  warped.difference = 0.5 * test_squares_ / values;
  warped.reference_difference = 0.5 * reference_squares_ / values;
  warped.share = static_cast<double>(compared_) / static_cast<double>(pixels_);
  return warped;
}

void SettleMeter::add(const scenes::Image& picture) {
  const std::vector<float> shown = scenes::display_values(picture, display_.exposure_ev, display_.tonemap);
  if (!pictures_.empty() && shown.size() != pictures_.front().size())
    throw Error(SIDERAY_INVALID_ARGUMENT, "a picture at rest: its size differs from the others'; compare equal sizes");
  std::vector<uint16_t> values(shown.size());
  std::transform(shown.begin(), shown.end(), values.begin(),
                 [](float v) { return static_cast<uint16_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 65535.0f)); });
  pictures_.push_back(std::move(values));
}

// Returns the ghost of each picture up to the start of the settled ones.
std::vector<double> SettleMeter::ghosts() const {
  std::vector<double> squares;
  for (uint32_t k = 0; k <= held - period; ++k) {
    const std::vector<uint16_t>& picture = pictures_[k];
    const std::vector<uint16_t>& settled = pictures_[held - (held - k) % period];
    double sum = 0;
    for (size_t i = 0; i < picture.size(); ++i) sum += square((picture[i] - settled[i]) / 65535.0);
    squares.push_back(sum / static_cast<double>(picture.size()));
  }
  double noise = 0;
  for (uint32_t k = 0; k < period; ++k) noise += squares[squares.size() - 1 - k] / period;
  for (double& s : squares) s = std::sqrt(std::max(0.0, s - noise));
  return squares;
}

Settling SettleMeter::result() const {
  if (pictures_.size() != held + 1 || pictures_.front().empty())
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("settling: {} pictures; give one in motion and {} at rest", pictures_.size(), held));
  const std::vector<double> ghost = ghosts();
  Settling settling;
  settling.ghost = ghost.front();
  if (ghost.front() <= tolerance) return settling;
  const auto frames = static_cast<uint32_t>(ghost.size());
  uint32_t half = 1;
  while (half + 1 < frames && ghost[half] > 0.5 * ghost.front()) ++half;
  settling.half_life =
      ghost[half] > 0.5 * ghost.front() ? half : crossing(half, ghost[half - 1], ghost[half], 0.5 * ghost.front());
  uint32_t settled = frames;
  while (settled > 0 && ghost[settled - 1] <= tolerance) --settled;
  settling.settle_time = settled;
  return settling;
}

const std::vector<std::string>& temporal_names() {
  static const std::vector<std::string> names{"flicker", "flicker_of_error", "warped_difference",
                                              "ghost",   "ghost_half_life",  "settle_time"};
  return names;
}

}  // namespace sideray::lab
