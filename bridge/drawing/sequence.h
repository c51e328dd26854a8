// Keeps what a renderer passes from one picture of a sequence to the next. The backend's thread.
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

// Holds everything that a picture is drawn from. Snapshots that show the same share one pointer.
struct PictureInputs {
  sideray_camera camera;
  RenderOptions options;
  std::shared_ptr<const model::Snapshot> snapshot;
};

class Sequence {
 public:
  explicit Sequence(Backend& backend) : backend_(backend) {}

  // Begins a picture; one that does not continue forgets the pictures before it. If done() then returns a picture, call
  // nothing else until the next begin().
  void begin(const FramePlan& plan, PictureInputs inputs);
  // Returns the last picture again, with its statistics, if a still view has added all positions; otherwise null.
  std::unique_ptr<Picture> done() const;
  // Ends a picture that the next one may continue. After a failure, when it is not called, none can.
  void keep(const FramePlan& plan, gl::FrameBefore frame, const Picture& picture);
  // Call it where another scene is drawn from now on.
  void forget() { is_kept_ = false; }

  const gl::FrameBefore& before() const { return before_; }
  // Returns whether the view stands still, so that the picture is added to those before.
  bool adds() const { return still_.adds(); }
  // Returns how many frames a position of a still view has taken under a budget, this one included; otherwise 0.
  uint32_t position_frames() const { return adds() && has_budget(inputs_.options) ? still_.position_frames() : 0; }
  // Returns whether the frame continues the last one: an accumulated picture uses no history. Under a budget it shows
  // history until it has its own answers, so that they are there when something moves.
  bool follows() const { return !adds() || position_frames() > 0; }
  // Returns whether pictures are accumulated and some tiles restart because they see something move. These tiles show
  // the temporal average.
  bool begins_tiles() const { return still_.adds() && still_.begins_tiles(); }
  // Returns the tiles to draw; null: all. The content of the others does not matter.
  std::shared_ptr<const rt::WantedTiles> wanted(const FramePlan& plan);
  // Returns the tiles of wanted() that are relit; in its other tiles masks and reflections stay as they are.
  std::shared_ptr<const rt::WantedTiles> wanted_light(const FramePlan& plan);
  // Return the offset of position `sample` from the pixel's centre, in pixels, and its random seed.
  glm::vec2 jitter(const FramePlan& plan, uint32_t sample) const;
  uint32_t seed(const FramePlan& plan, uint32_t sample) const;
  // Returns the number of position `sample` among those that a still view or a picture averages; 0 in motion.
  uint32_t position(uint32_t sample) const { return adds() ? still_.position() : sample; }
  // Returns the number of positions that the picture averages.
  uint32_t positions(const FramePlan& plan) const { return adds() ? std::max(still_.added(), 1u) : plan.samples; }
  // Takes the drawn colours, bottom row first, and replaces them by those to show. `trace`: counters that tell which
  // answers are late. `average`: with begins_tiles(), the temporal average that includes them.
  void show(const FramePlan& plan, const rt::Counters& trace, std::vector<glm::vec4>& colors,
            const std::vector<glm::vec4>& average);

 private:
  static bool has_budget(const RenderOptions& options);
  bool draws_alike(const FramePlan& plan, const PictureInputs& inputs) const;
  bool repeat(const FramePlan& plan, const PictureInputs& inputs, const std::vector<rt::Mover>& movers);
  std::shared_ptr<const rt::WantedTiles> wanted(const FramePlan& plan, std::vector<uint8_t> (StillPicture::*tiles)() const);

  Backend& backend_;
  bool is_kept_ = false;  // the next picture may continue the last one
  PictureInputs inputs_;  // of the last picture
  FramePlan plan_{};      // of the last picture
  gl::FrameBefore before_;
  uint32_t averaged_ = 0;  // pictures in a row that were averaged over time before this one
  uint32_t rests_for_ = 0;   // pictures since something changed, this one included
  bool is_settled_ = false;  // the last one showed no history from before that change
  StillPicture still_;
  std::shared_ptr<rt::TileReach> reach_;  // of the still view's rays
  bool is_restless_ = false;  // so much moved that the whole picture restarted, and the view has not rested since
  Picture last_;  // set once it is done
};

}  // namespace sideray::bridge
