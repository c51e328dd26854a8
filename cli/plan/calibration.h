// Measures the cost of configurations on this machine and their error against the reference, on reduced frames of the
// session's view, and caches both. Main thread.
#pragma once

#include <map>
#include <nlohmann/json.hpp>

#include "cli/session/session.h"
#include "lab/prediction/calibration_cache.h"
#include "lab/prediction/picking.h"
#include "lab/prediction/prediction.h"

namespace sideray::cli {

class Calibration {
 public:
  // Throws Error where this machine can draw nothing.
  Calibration(Session& session, const RenderOptions& options);

  // Measures a frame with these options; in a sequence, the second one. `options` must not be a reference. Work and
  // times are those of one camera position, whatever `--samples` says.
  lab::Probe probe(const RenderOptions& options);
  // Times the whole frame; returns its prediction `foretold_ms` if the probe's larger frame was the whole one already.
  double drawn_ms(const RenderOptions& options, double foretold_ms);
  // Measures only the smaller frame: its time, and where possible its mean FLIP against the reference of the options
  // that the calibration was made with.
  lab::Look look(const RenderOptions& options);

 private:
  nlohmann::json key(const char* what, const RenderOptions& options) const;
  Session::Drawn draw(const RenderOptions& options, lab::FrameSize size, uint32_t repeats);
  lab::FrameCost measure(const RenderOptions& options, lab::FrameSize size, uint32_t repeats);
  lab::Probe draw_probe(const RenderOptions& options);
  const scenes::Image& reference();
  double draw_ms(const RenderOptions& options, lab::FrameSize size);

  Session& session_;
  lab::CalibrationCache cache_;
  nlohmann::json machine_, scene_;
  RenderOptions exact_;                       // options of the reference
  std::map<std::string, lab::Probe> probes_;  // of this run, cached on disk or not
  std::optional<scenes::Image> reference_;
};

// Returns whether frames with these options can be predicted: references take minutes, reduced or not.
bool is_predictable(const RenderOptions& options);

// Predicts the work and time of a whole frame with these options, within what its plan allows.
lab::FrameCost predict(const lab::Probe& probe, const RenderOptions& options, const sideray_plan_work& most);

}  // namespace sideray::cli
