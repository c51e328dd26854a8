#include "bridge/options/same_options.h"

#include <algorithm>

#include "bridge/options/option_row.h"

namespace sideray::bridge {
namespace {

OptionValues what_counts(const RenderOptions& options) {
  OptionValues values;
  static_cast<RenderOptions&>(values) = options;
  values.picture.continues = 0;
  values.picture.repeats = 0;
  for (const OptionRow& row : option_table())
    if (row.is_random) row.store(values, OptionValue{});
  return values;
}

// Compares the options that have rows, wherever their fields are.
bool same_rows(const OptionValues& a, const OptionValues& b) {
  return std::ranges::all_of(option_table(),
                             [&](const OptionRow& row) { return !row.load || row.load(a) == row.load(b); });
}

}  // namespace

bool draw_alike(const RenderOptions& first, const RenderOptions& second) {
  const OptionValues a = what_counts(first), b = what_counts(second);
  return same_rows(a, b) && same_through(&sideray_render_options::without_color, a.picture, b.picture) &&
         same_through(&sideray_translucency_options::bounces, a.translucency, b.translucency) &&
         same_through(&sideray_shadow_options::bias, a.shadows, b.shadows) &&
         same_through(&sideray_pose_options::cull_angle_deg, a.poses, b.poses) && a.is_reference == b.is_reference &&
         same_through(&sideray_reference_options::caustics, a.reference, b.reference) &&
         a.diagnostics.exact_points == b.diagnostics.exact_points &&
         a.diagnostics.budget_pieces == b.diagnostics.budget_pieces;
}

}  // namespace sideray::bridge
