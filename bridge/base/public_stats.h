// Copies counters into the public structs. Any thread.
#pragma once

#include "rt/base/counters.h"

namespace sideray::bridge {

// Sets every counter that `stats` has under the same name.
template <typename Stats>
void set_stats(Stats& stats, const rt::Counters& counters) {
#define SIDERAY_SET(name) \
  if constexpr (requires { stats.name; }) stats.name = counters.name;
  SIDERAY_COUNTERS(SIDERAY_SET, SIDERAY_SET, SIDERAY_SET)
#undef SIDERAY_SET
}

}  // namespace sideray::bridge
