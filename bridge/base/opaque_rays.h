// Decides whether ambient occlusion, light that surfaces throw on each other, and reflections of opaque surfaces are traced where that is left to the plan, from the
// scene alone: all frames of a sequence decide alike. Any thread may call it.
#pragma once

#include "model/snapshot.h"

namespace sideray::bridge {

struct OpaqueRays {
  const char* why_no_ao;           // static text; null: AUTO traces it
  const char* why_no_bounce;       // likewise
  const char* why_no_reflections;  // likewise
};

OpaqueRays opaque_rays_of(const model::Snapshot& snapshot);

}  // namespace sideray::bridge
