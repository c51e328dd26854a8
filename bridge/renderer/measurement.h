// Draws a finished picture again, to time its stages and count its fragments. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Draws the frames of the picture `repeats` times with each stage timed separately and as often as a whole, then once
// more to count.
void measure(PictureJob& job, Picture& picture);

// Draws and times in one go a picture whose translucent surfaces are a reference: tracing takes so long that the
// previous frame and the fences between stages do not matter.
void draw_timed(PictureJob& job, Picture& picture);

// Fills in threads, instruction set and Embree version.
void describe_tracer(const PictureJob& job, sideray_render_stats& stats);

// Times a raw frame of the view, where options request one and rays are traced. Takes the tracer's turn.
void measure_raw_frame(const PictureJob& job);

}  // namespace sideray::bridge
