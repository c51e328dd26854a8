// Sums of frames' statistics, field by field in one place. Any thread.
#pragma once

#include <sideray/service.h>

namespace sideray::bridge {

// Times and counts add up; bytes_cache is what the largest frame holds.
sideray_frame_stats& operator+=(sideray_frame_stats& sum, const sideray_frame_stats& frame);

}  // namespace sideray::bridge
