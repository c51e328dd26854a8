// Charts a sequence: draws the reference and the motion of every frame, and measures configurations over all frames.
// Main thread.
#pragma once

#include "cli/base/progress.h"
#include "cli/chart/chart_folder.h"
#include "cli/session/session.h"

namespace sideray::cli {

class ChartSequence {
 public:
  // The session must be at the first frame.
  ChartSequence(const ChartOptions& options, const ChartFolder& folder, Session& session);

  size_t reference_steps() const { return frames_.count() + 1; }
  // Draws the frames that no earlier run left.
  lab::ChartReference draw_reference(Progress& progress);

  // Returns the error over all frames; leaves the last frame in `picture`.
  lab::Json draw(const RenderOptions& sequence, const std::string& picture);
  // Returns the stats of every frame, timed once.
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
