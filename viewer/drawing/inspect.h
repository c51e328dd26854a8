// Finds what lies behind a pixel. Any thread.
#pragma once

#include "viewer/drawing/view.h"

namespace sideray::viewer {

// `tracer` holds the view's scene at its time.
Inspection inspect(Tracer& tracer, const View& view, Pixel pixel);

// What a pixel of the view shows of the rays in a picture of it, and how old that is: one line. The picture may be smaller.
std::string answers_at(const Frame& frame, const View& view, Pixel pixel);

}  // namespace sideray::viewer
