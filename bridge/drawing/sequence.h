// What a renderer keeps from one picture of a sequence to the next. The backend's thread.
#pragma once

#include <algorithm>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "bridge/base/render_options.h"
#include "bridge/drawing/backend.h"
#include "bridge/picture/picture.h"
#include "bridge/picture/still_picture.h"
#include "bridge/plan/frame_plan.h"
#include "gl/passes/pass_inputs.h"
#include "rt/base/counters.h"
#include "rt/reach/wanted_tiles.h"
#include "rt/scene/scene_difference.h"

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
  // Under a budget a position of a still view takes several frames: how many it has taken, this one included; otherwise 0.
  uint32_t position_frames() const { return adds() && has_budget(inputs_.options) ? still_.position_frames() : 0; }
  // Whether the frame continues the last one: a picture that is accumulated uses no history. Under a budget it shows
  // history until it has its own answers, so that they are there when something moves.
  bool follows() const { return !adds() || position_frames() > 0; }
  // Whether pictures are accumulated and some tiles restart, since they see something move. These show the temporal
  // average.
  bool begins_tiles() const { return still_.adds() && still_.begins_tiles(); }
  // The tiles that must be drawn; null: all. The contents of the others do not matter.
  std::shared_ptr<const rt::WantedTiles> wanted(const FramePlan& plan);
  // Of these, those in which surfaces are lit anew; in the others masks and reflections are as they were.
  std::shared_ptr<const rt::WantedTiles> wanted_light(const FramePlan& plan);
  // Where the picture's position of number `sample` lies, in pixels from the pixel's centre, and its random numbers.
  glm::vec2 jitter(const FramePlan& plan, uint32_t sample) const;
  uint32_t seed(const FramePlan& plan, uint32_t sample) const;
  // How many positions the picture is the mean of.
  uint32_t positions(const FramePlan& plan) const { return adds() ? std::max(still_.added(), 1u) : plan.samples; }
  // Takes the colours that were drawn, bottom row first, and makes them those to be shown. `trace`: what rays had a turn. `average`:
  // with begins_tiles(), what the average over time makes of them.
  void show(const FramePlan& plan, const rt::Counters& trace, std::vector<glm::vec4>& colors,
            const std::vector<glm::vec4>& average);

 private:
  static bool has_budget(const RenderOptions& options);
  bool draws_alike(const FramePlan& plan, const PictureInputs& inputs) const;
  bool repeat(const FramePlan& plan, const PictureInputs& inputs, const std::vector<rt::Mover>& movers);
  std::shared_ptr<const rt::WantedTiles> wanted(const FramePlan& plan, std::vector<uint8_t> (StillPicture::*tiles)() const);

  Backend& backend_;
  bool is_kept_ = false;  // the next picture may continue the last one
  PictureInputs inputs_;  // of the last one
  FramePlan plan_{};      // likewise
  gl::FrameBefore before_;
  uint32_t averaged_ = 0;  // pictures in a row that were averaged over time before this one
  uint32_t rests_for_ = 0;   // pictures since something has changed, this one included
  bool is_settled_ = false;  // the last one showed no history from before that change
  StillPicture still_;
  std::shared_ptr<rt::TileReach> reach_;  // of its rays
  bool is_restless_ = false;  // so much moved that the whole picture restarted, and the view has not been at rest since
  Picture last_;  // once it is done
};

}  // namespace sideray::bridge
