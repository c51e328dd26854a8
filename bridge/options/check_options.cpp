#include "bridge/options/check_options.h"

#include <cmath>

#include "bridge/options/option_row.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t most_repeats = 10000;
constexpr float most_stops = 64.0f;

// Returns whether a reference reads the row: it decides some rows itself, which then accept no value.
bool is_read(const OptionRow& row, const OptionValues& v) {
  const bool is_decided = row.beside_reference && !*row.beside_reference;
  return !v.is_reference || !is_decided;
}

void check_rows(const OptionValues& values) {
  for (const OptionRow& row : option_table()) {
    if (!row.load || !is_read(row, values)) continue;
    const OptionValue value = read_option(row, values);
    if (row.check && row.checks_structs) row.check(values, value);
  }
}

// Checks fields that only the structs have.
void check_picture(const RenderOptions& o) {
  if (o.picture.repeats > most_repeats)
    fail(SIDERAY_INVALID_ARGUMENT, "repeats {}: give 0 to {}", o.picture.repeats, most_repeats);
  if (!(o.picture.exposure >= -most_stops && o.picture.exposure <= most_stops))
    fail(SIDERAY_INVALID_ARGUMENT, "exposure {}: give {} to {} stops", o.picture.exposure, -most_stops, most_stops);
  if (!(o.shadows.bias >= 0.0f && std::isfinite(o.shadows.bias)))
    fail(SIDERAY_INVALID_ARGUMENT, "shadow bias {}: give a finite length of 0 or more", o.shadows.bias);
  if (o.is_reference && o.picture.without_color)
    fail(SIDERAY_INVALID_ARGUMENT, "without_color: a reference is its colours; leave one of them out");
  if (o.is_reference && o.shows(SIDERAY_AOV_MASK | SIDERAY_AOV_LAYERS | SIDERAY_AOV_ANSWERS))
    fail(SIDERAY_INVALID_ARGUMENT, "reference: has no mask, no layers and no answers to show; leave SIDERAY_AOV_{} out",
         o.shows(SIDERAY_AOV_MASK) ? "MASK" : o.shows(SIDERAY_AOV_LAYERS) ? "LAYERS" : "ANSWERS");
}

}  // namespace

void check_options(const RenderOptions& options) {
  check_size(options.picture.width, options.picture.height);
  OptionValues values;
  static_cast<RenderOptions&>(values) = options;
  check_rows(values);
  check_picture(options);
}

}  // namespace sideray::bridge
