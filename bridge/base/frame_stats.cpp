#include "bridge/base/frame_stats.h"

#include <algorithm>

namespace sideray::bridge {
namespace {

using Stats = sideray_frame_stats;

constexpr double Stats::*times[] = {&Stats::readback_ms, &Stats::trace_ms,        &Stats::denoise_ms,
                                    &Stats::upload_ms,   &Stats::trace_shadow_ms, &Stats::trace_ao_ms};

constexpr uint64_t Stats::*counts[] = {
    &Stats::rays_primary,  &Stats::rays_reflection,   &Stats::rays_shadow,       &Stats::rays_ao,
    &Stats::pixels_total,  &Stats::pixels_masked,     &Stats::layers_requested,  &Stats::layers_found,
    &Stats::traversals_wasted, &Stats::pixels_late,   &Stats::dropped_particles, &Stats::rays_skipped,
    &Stats::layers_skipped, &Stats::bytes_readback,   &Stats::bytes_upload,      &Stats::points_shaded,
    &Stats::points_not_finite};

}  // namespace

sideray_frame_stats& operator+=(sideray_frame_stats& sum, const sideray_frame_stats& frame) {
  for (const auto time : times) sum.*time += frame.*time;
  for (const auto count : counts) sum.*count += frame.*count;
  sum.bytes_cache = std::max(sum.bytes_cache, frame.bytes_cache);
  return sum;
}

}  // namespace sideray::bridge
