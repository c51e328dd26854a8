// Resolves `auto` for ambient occlusion, bounced light and reflections of opaque surfaces. Only the scene decides, so
// that all frames of a sequence agree. Any thread may call it.
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
