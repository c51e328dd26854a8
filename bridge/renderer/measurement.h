// Draws a finished picture again, for times of its stages and counts of its fragments. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Draws the frames of the picture `repeats` times with each stage by itself and as often without stages, then once more
// to count.
void measure(PictureJob& job, Picture& picture);

// Draws a picture whose translucent surfaces are a reference, and times it as it is drawn: tracing takes so long that
// neither the previous frame nor the fences between stages count in it.
void draw_timed(PictureJob& job, Picture& picture);

// Says what traced the picture.
void describe_tracer(const PictureJob& job, sideray_render_stats& stats);

// Times a raw frame of the view, where the options want one and rays are traced. It takes the tracer's turn.
void measure_raw_frame(const PictureJob& job);

}  // namespace sideray::bridge
