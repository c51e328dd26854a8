// What --truth writes: boxes, masks and coverage of every object of a picture, in COCO's layout. Main thread.
#pragma once

#include "cli/options/render_options.h"
#include "cli/session/session.h"

namespace sideray::cli {

// Traces the objects as the session's last picture shows them, and writes options.truth, whole or not at all; nothing
// where no such file was asked for. `frame`: the picture's number. Throws Error.
void write_truth(Session& session, const RenderOptions& options, uint32_t frame);

// Whether the file is there, or none was asked for.
bool has_truth(const RenderOptions& options);

}  // namespace sideray::cli
