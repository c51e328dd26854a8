// A chart over a sequence: the reference and the motion of every frame, and what a configuration makes of them.
// Main thread.
#pragma once

#include "cli/base/progress.h"
#include "cli/chart/chart_folder.h"
#include "cli/session/session.h"

namespace sideray::cli {

class ChartSequence {
 public:
  // The session stands as the first frame does.
  ChartSequence(const ChartOptions& options, const ChartFolder& folder, Session& session);

  size_t reference_steps() const { return frames_.count() + 1; }
  // Draws the frames that no earlier run left.
  lab::ChartReference draw_reference(Progress& progress);

  // The error of all frames; `picture` is left with the last one.
  lab::Json draw(const RenderOptions& sequence, const std::string& picture);
  // The stats of every frame, timed once.
  std::vector<lab::Json> measure(const RenderOptions& sequence);

 private:
  Session::Drawn draw_frame(const RenderOptions& frame);
  void draw_motion(bool keeps);

  const ChartOptions& options_;
  const ChartFolder& folder_;
  Session& session_;
  FrameRange frames_;
  std::string reference_pattern_, motion_pattern_;
};

}  // namespace sideray::cli
