#include "rt/poses/angle_cull.h"

#include <algorithm>
#include <atomic>
#include <numbers>
#include <utility>

#include "elementary/functions.h"

namespace sideray::rt {
namespace {

constexpr size_t instances_in_piece = 8192;

// Returns the smallest radius that is not culled, as a share of the distance.
double share_of(double angle_deg) {
  return elementary::sin(0.5 * std::min(angle_deg, 180.0) * std::numbers::pi / 180.0);
}

}  // namespace

void AngleCull::follow(const model::Snapshot& snapshot) {
  const size_t count = snapshot.instances.size();
  if (snapshot.instance_names == names_) {
    culled_.resize(count);
    return;
  }
  std::vector<uint8_t> followed(count, 0);
  for (size_t i = 0; i < count; ++i) {
    const uint32_t before = model::find_name(names_, culled_.size(), snapshot.instance_names[i]);
    if (before != model::no_index) followed[i] = culled_[before];
  }
  culled_ = std::move(followed);
  names_ = snapshot.instance_names;
}

bool AngleCull::update(const model::Snapshot& snapshot, float angle_deg, glm::vec3 eye, Executor& executor,
                       CullRules rules) {
  if (!(angle_deg > 0.0f)) {
    const bool changed = std::find(culled_.begin(), culled_.end(), 1) != culled_.end();
    culled_.clear();
    names_ = {};
    return changed;
  }
  const double leaves = share_of(double{angle_deg}), returns = share_of(back * double{angle_deg});
  const size_t count = snapshot.instances.size();
  follow(snapshot);
  std::atomic<bool> changed{false};
  executor.run((count + instances_in_piece - 1) / instances_in_piece, [&](size_t piece, uint32_t) {
    bool piece_changed = false;
    const size_t last = std::min((piece + 1) * instances_in_piece, count);
    for (size_t i = piece * instances_in_piece; i < last; ++i) {
      const model::Instance& instance = snapshot.instances[i];
      const model::Bounds& bounds = instance.bounds;
      const bool kept = rules.keeps_translucent && snapshot.materials[instance.material].translucent;
      const double radius = double{bounds.radius()};
      const double distance = glm::length(glm::dvec3(bounds.center()) - glm::dvec3(eye));
      // For empty bounds the distance is NaN.
      const double share = culled_[i] && rules.remembers ? returns : leaves;
      const bool small = !kept && radius < distance && radius < distance * share;
      piece_changed |= culled_[i] != static_cast<uint8_t>(small);
      culled_[i] = small;
    }
    if (piece_changed) changed = true;
  });
  return changed;
}

}  // namespace sideray::rt
