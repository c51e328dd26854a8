// `sideray render`: draws one frame, from the options to the exit code. Main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/render/run_pictures.h"

namespace sideray::cli {

// `job`: the record of a picture in a run that many tasks share. With --frames and a scheduler's shard, the render is
// such a run itself.
int render(const RenderOptions& options, const RunJob* job = nullptr);
// Checks before any work that the files can be written and read. Throws UsageError or Error.
void check_render(const RenderOptions& options);

// Runs the renders of a --jobs file: an array of {option: value} with "scene" and "o". `given` applies to every job
// that does not set it. All jobs are checked before the first runs. With --shard, sequences are shared by frames, and
// single pictures are dealt out in turn. Returns the first exit code that is not 0.
int render_jobs(const std::string& path, const Given& given);

}  // namespace sideray::cli
