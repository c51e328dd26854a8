// Answers questions about a committed scene that decide what its frames do and which options matter. Any thread.
#pragma once

#include <sideray/plan.h>

#include "gl/rasterizer.h"
#include "model/snapshot.h"

namespace sideray::bridge {

// Counting stops at this many surfaces.
inline constexpr uint64_t most_counted_surfaces = 64;

bool is_traced(const model::Snapshot& snapshot, const model::Instance& instance, gl::TracedSet set);
bool has_traced(const model::Snapshot& snapshot, gl::TracedSet set);

// Returns how many traced surfaces a ray through the scene hits at most; `enough` where it may be as many or more.
uint64_t most_surfaces(const model::Snapshot& snapshot, gl::TracedSet traced, uint64_t enough);

bool has_sprites(const model::Snapshot& snapshot);
uint64_t count_translucent(const model::Snapshot& snapshot);

// Returns whether a light emits anything.
bool is_lit(const model::Light& light);
bool has_lit_light(const model::Snapshot& snapshot, size_t first = 0);

bool has_inexact(const model::Snapshot& snapshot, sideray_inexact_target target);
bool has_distortion(const model::Snapshot& snapshot);
// Returns whether any surface tints the light that passes it.
bool has_tints(const model::Snapshot& snapshot);

sideray_scene_facts scene_facts(const model::Snapshot& snapshot);

}  // namespace sideray::bridge
