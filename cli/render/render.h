// `sideray render`: one frame, from the options to the exit code. Main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/render/run_pictures.h"

namespace sideray::cli {

// `job`: what a run that many tasks share records of it. With --frames and a shard that a scheduler gives it is such a run
// itself.
int render(const RenderOptions& options, const RunJob* job = nullptr);
// What render() finds out before any work: that its files can be written and read. Throws UsageError or Error.
void check_render(const RenderOptions& options);

// The renders of a --jobs file: an array of {option: value} with "scene" and "o". `given` holds for every job that
// does not say otherwise. All are checked before the first runs. With --shard, sequences are shared by their frames and
// single pictures go round. Returns the first exit code that is not 0.
int render_jobs(const std::string& path, const Given& given);

}  // namespace sideray::cli
