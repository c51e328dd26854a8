// Finds what lies behind a pixel. Any thread.
#pragma once

#include "viewer/drawing/view.h"

namespace sideray::viewer {

// `tracer` holds the view's scene at its time.
Inspection inspect(Tracer& tracer, const View& view, Pixel pixel);

}  // namespace sideray::viewer
