// What a renderer keeps from one picture of a sequence to the next. The backend's thread.
#pragma once

#include <glm/glm.hpp>
#include <memory>

#include "bridge/base/render_options.h"
#include "bridge/drawing/backend.h"
#include "bridge/picture/picture.h"
#include "bridge/picture/still_picture.h"
#include "bridge/plan/frame_plan.h"
#include "gl/passes/pass_inputs.h"

namespace sideray::bridge {

// All that a picture is drawn from. Snapshots that show the same are one.
struct PictureInputs {
  sideray_camera camera;
  RenderOptions options;
  std::shared_ptr<const model::Snapshot> snapshot;
};

class Sequence {
 public:
  explicit Sequence(Backend& backend) : backend_(backend) {}

  // A picture begins: where it continues none, the pictures before it are forgotten. Where it is done() already, nothing
  // else is to be called until the next one begins.
  void begin(const FramePlan& plan, PictureInputs inputs);
  // Returns the last picture once more, with its statistics, where a still view has added up all positions; otherwise null.
  std::unique_ptr<Picture> done() const;
  // The picture is done, and the next one may continue it. After a failure no picture can.
  void keep(const FramePlan& plan, gl::FrameBefore frame, const Picture& picture);
  // Another scene is drawn from now on.
  void forget() { is_kept_ = false; }

  const gl::FrameBefore& before() const { return before_; }
  // Whether the view stands still, so that the picture is added to those before.
  bool adds() const { return still_.adds(); }
  // Where the picture's position of number `sample` lies, in pixels from the pixel's centre, and its random numbers.
  glm::vec2 jitter(const FramePlan& plan, uint32_t sample) const;
  uint32_t seed(const FramePlan& plan, uint32_t sample) const;
  // How many positions the picture is the mean of.
  uint32_t positions(const FramePlan& plan) const { return adds() ? still_.added() : plan.samples; }
  // Takes the colours that were drawn, bottom row first, and makes them those to be shown.
  void show(const FramePlan& plan, std::vector<glm::vec4>& colors);

 private:
  bool repeats_last(const FramePlan& plan, const PictureInputs& inputs) const;

  Backend& backend_;
  bool is_kept_ = false;  // the next picture may continue the last one
  PictureInputs inputs_;  // of the last one
  gl::FrameBefore before_;
  uint32_t averaged_ = 0;  // pictures in a row that were averaged over time before this one
  StillPicture still_;
  Picture last_;  // once it is done
};

}  // namespace sideray::bridge
