// The frames of a sequence, drawn and written one after the other. Any thread but render_frames: main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/options/sequence_plan.h"
#include "cli/render/run_pictures.h"

namespace sideray::cli {

// One frame of a sequence as the picture that it is.
RenderOptions frame_options(const RenderOptions& sequence, const Step& step);
// Whether a picture depends on those before it.
bool has_past(const RenderOptions& sequence);

// Throws UsageError or Error where the files of the sequence cannot be written, or two of them are one.
void check_frames(const RenderOptions& options);
// Draws and writes the frames of the shard in turn, with --resume those that are missing; their stats are one object a
// line, or in a run that many tasks share (`job`) in the sidecars. Returns the exit code.
int render_frames(const RenderOptions& options, const RunJob* job = nullptr);

}  // namespace sideray::cli
