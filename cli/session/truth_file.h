// Writes --truth: boxes, masks and coverage of every object of a picture, in COCO's layout. Main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/session/session.h"

namespace sideray::cli {

// Traces the objects as the session's last picture shows them, and writes options.truth, completely or not at all, if
// it is set. `frame`: the picture's number. Throws Error.
void write_truth(Session& session, const RenderOptions& options, uint32_t frame);

// Returns whether the file exists, or none was requested.
bool has_truth(const RenderOptions& options);

}  // namespace sideray::cli
