// `sideray render`: one frame, from the options to the exit code. Main thread.
#pragma once

#include "cli/options/render_options.h"

namespace sideray::cli {

int render(const RenderOptions& options);
// What render() finds out before any work: that its files can be written and read. Throws UsageError or Error.
void check_render(const RenderOptions& options);

// The renders of a --jobs file: an array of {option: value} with "scene" and "o". `defaults` hold for every job that
// does not say otherwise. All are checked before the first runs. Returns the first exit code that is not 0.
int render_jobs(const std::string& path, const Given& defaults);

}  // namespace sideray::cli
