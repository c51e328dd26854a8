// Finds the surfaces along the ray of a pixel. Any thread.
#pragma once

#include "viewer/drawing/view.h"

namespace sideray::viewer {

// `tracer` must hold the view's scene at the view's time.
Inspection inspect(Tracer& tracer, const View& view, Pixel pixel);

// Says in one line which ray-traced answers a pixel of the view shows in a picture of it, and how old they are. The
// picture may be smaller than the view.
std::string answers_at(const Frame& frame, const View& view, Pixel pixel);

}  // namespace sideray::viewer
