// What a configuration costs on this machine and how far it is from the reference, measured on reduced frames of the
// session's view once and kept. Main thread.
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
  // Throws Error where nothing can be drawn here.
  Calibration(Session& session, const RenderOptions& options);

  // Measures a frame drawn with these options, in a sequence the one after the first. `options` is no reference. Work
  // and times are those of one camera position, whatever `--samples` says.
  lab::Probe probe(const RenderOptions& options);
  // Times a whole frame: what `foretold_ms` says of it, measured. That itself where the probe's larger frame is whole.
  double drawn_ms(const RenderOptions& options, double foretold_ms);
  // Looks at the smaller frame alone: its time, and the mean FLIP against the reference of the options that the
  // calibration was made with, where it has one.
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
  RenderOptions exact_;                       // of the reference
  std::map<std::string, lab::Probe> probes_;  // of this run, whether they can be kept or not
  std::optional<scenes::Image> reference_;
};

// Whether frames of these options can be predicted: references are drawn in minutes, reduced or not.
bool is_predictable(const RenderOptions& options);

// Predicts what a whole frame of these options counts and takes, within what its plan allows.
lab::FrameCost predict(const lab::Probe& probe, const RenderOptions& options, const sideray_plan_work& most);

}  // namespace sideray::cli
