#include "cli/golden/golden_verdict.h"

#include <fmt/format.h>

namespace sideray::cli {
namespace {

constexpr size_t changes_in_a_line = 6;

std::string share_text(double share) {
  return fmt::format("{:.3g} %", 100 * share);
}

// Returns whether a picture of another driver is within its bound: bits may differ, objects may not.
bool is_within_drift(const Verdict& verdict) {
  const auto bound = verdict.reference.drifts.find(verdict.drawn.driver);
  if (bound == verdict.reference.drifts.end() || !verdict.differences.has_same_ids || !verdict.differences.flip)
    return false;
  const Drift drift = verdict.drift();
  return verdict.drawn.camera == verdict.reference.camera && drift.flip <= bound->second.flip &&
         drift.share <= bound->second.share;
}

std::string amount(const Verdict& verdict) {
  const std::string share = share_text(verdict.drift().share) + " of the pixels";
  return verdict.differences.flip ? fmt::format("FLIP {:.2g}, {}", *verdict.differences.flip, share)
                                  : fmt::format("{}, some of them not finite", share);
}

std::string driver_text(const Verdict& verdict) {
  const bool is_bound = verdict.reference.drifts.contains(verdict.drawn.driver);
  return fmt::format("; drawn by {}, recorded by {}{}", verdict.drawn.driver, verdict.reference.driver,
                     is_bound ? ", more than was approved for it" : "");
}

std::string text_on(const Verdict& verdict) {
  if (verdict.differences.is_equal) return "equal";
  if (verdict.holds) return fmt::format("within the drift of {} ({})", verdict.drawn.driver, amount(verdict));
  std::string text = lab::describe(verdict.differences.changes, changes_in_a_line);
  text = text.empty() ? fmt::format("differs ({})", amount(verdict)) : text;
  return verdict.drawn.driver == verdict.reference.driver ? text : text + driver_text(verdict);
}

}  // namespace

Drift Verdict::drift() const {
  const double pixels = static_cast<double>(drawn.width) * drawn.height;
  return {differences.flip.value_or(1), static_cast<double>(differences.pixels) / pixels};
}

Verdict verdict_on(DrawnPicture&& drawn, const GoldenPicture& recorded, const scenes::Image& reference,
                   const scenes::Image& ids) {
  Verdict verdict;
  verdict.drawn = std::move(drawn.golden);
  verdict.reference = recorded;
  verdict.display = drawn.display;
  verdict.seconds = drawn.seconds;
  if (verdict.drawn.digest != recorded.digest)
    verdict.differences = lab::differences(
        {drawn.picture, drawn.ids, verdict.drawn.objects}, {reference, ids, recorded.objects},
        {drawn.objects, verdict.drawn.camera == recorded.camera, &drawn.radiance}, drawn.display);
  verdict.holds = verdict.differences.is_equal || is_within_drift(verdict);
  verdict.differences.flip_map = {};  // the maps of all pictures would take much memory
  verdict.text = text_on(verdict);
  return verdict;
}

}  // namespace sideray::cli
