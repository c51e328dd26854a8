// Draws and writes the frames of a sequence one after another. Any thread, but render_frames: main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/options/sequence_plan.h"
#include "cli/render/run_pictures.h"

namespace sideray::cli {

// Returns the options of a single picture for one frame of a sequence.
RenderOptions frame_options(const RenderOptions& sequence, const Step& step);
// Returns whether a picture depends on earlier ones.
bool has_past(const RenderOptions& sequence);

// Throws UsageError or Error where files of the sequence cannot be written, or two of them are the same.
void check_frames(const RenderOptions& options);
// Draws and writes the frames of the shard in turn, with --resume only missing ones. Stats have one object a line, or
// are in the sidecars of a run that many tasks share (`job`). Returns the exit code.
int render_frames(const RenderOptions& options, const RunJob* job = nullptr);

}  // namespace sideray::cli
