// Handles the program's frames, one after the other. Draws pass to the driver, are captured for rays, or are held back
// until their rays are traced.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "preload/base/rules.h"
#include "preload/base/settings.h"
#include "preload/capture/textures.h"
#include "preload/frame/comparison.h"
#include "preload/frame/scene_file.h"
#include "preload/frame/survey.h"
#include "preload/gl/saved_state.h"
#include "preload/rays/receivers.h"
#include "preload/rays/reflections.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

// Says what is done with a draw, and by which rule.
struct Decision {
  Taking taking = Taking::left;
  Rule rule;
  bool is_seen = false;   // rays can hit it
  bool in_turn = false;   // it does not wait for rays; it is held only to draw the frame both ways
  bool holds() const { return taking == Taking::reflects || taking == Taking::held || in_turn; }
};

inline constexpr float untinted[4] = {1, 1, 1, 1};

// A piece of geometry in a draw that is held back.
struct Piece {
  std::shared_ptr<const Geometry> geometry;
  uint64_t hash = 0;
  DrawState state;
  Decision decision;
};

class Frame {
 public:
  Frame();
  ~Frame();

  // Decides what is done with a draw. First makes the held draws, if this one depends on them. `geometry`, `mesh`: null
  // and 0 = not known yet.
  Decision decide(const DrawState& state, const Geometry* geometry, uint64_t mesh);
  // Returns whether rules or the report need the geometry of every draw.
  bool names_meshes() const { return rules_.has_meshes() || !settings().report.empty(); }
  // Returns whether a draw's geometry is needed.
  bool wants(const Decision& decision) const { return decision.holds() || (decision.is_seen && wants_scene()); }
  void show(Piece piece, const float tint[4]);
  // Holds a draw back: geometry, or a display list if `list` is not 0.
  void hold(std::vector<Piece> pieces, GLuint list, const float tint[4]);
  // Returns whether the frame is drawn both ways: draws that are held back are also made in their turn, for the
  // program's own picture.
  bool compares() const { return compares_; }
  // Stops drawing the frame both ways, because a draw cannot be held back.
  void compare_no_more();

  bool is_holding() const { return !held_.empty(); }
  // Returns whether held draws or shadows are still to be drawn in this frame.
  bool is_waiting() const { return is_holding() || !receivers_.empty() || casts_; }
  // Returns whether flush() runs. OpenGL calls that the program makes meanwhile mostly come from a signal handler.
  bool is_flushing() const { return flushing_; }
  // Draws shadows, and makes all draws that are held back.
  void flush();
  // Ends the frame, at the swap.
  void end();
  // Releases everything before the context is destroyed. `current`: the context can still be used.
  void close(bool current);
  // Holds no draw back from now on, and prints the reason once.
  void give_up(const std::string& reason);
  bool gave_up() const { return !ended_.empty(); }

  Textures& textures() { return textures_; }
  Survey& survey() { return survey_; }
  void write_report() const;

 private:
  struct Held {
    std::vector<Piece> pieces;
    GLuint list = 0;
    SavedState state;
    std::vector<Reflector> reflectors, bending;  // drawn after this draw, and before it
    bool in_turn = false;
    bool in_shadow = false;  // shadows may fall on it

    HeldDraw draw() const;
  };
  enum class Draws { all, in_turn, waiting };
  // Moves the reflectors to the last of several stages that draw one surface.
  void pass_on_reflectors(Held& next);
  bool is_later_stage(const Piece& piece) const;
  bool is_light_map_of_pending(const Piece& piece) const;
  void add_pending();
  void write_scene();
  Taking taking_of(const DrawState& state, const Rule& rule) const;
  bool has_other_view(const DrawState& state) const;
  // Returns whether the draw would look different if the held draws were made after it.
  bool depends_on_held(const DrawState& state) const;
  bool wants_scene() const { return tracing_ && !settings().off; }
  // Returns whether blended draws must wait for held draws or shadows that lie behind them.
  bool holds_later() const { return is_holding() || casts_; }
  bool is_lit_by_sun(const DrawState& state) const { return rules_.sun() >= 0 && state.lighting && Receivers::may_receive(state); }
  Batch batch() const;
  // Returns whether the draw hides what lies behind it, except in holes of its texture.
  bool covers(const DrawState& state, const Geometry* geometry, bool& has_holes);
  void make_scene();
  void add_reflector(Held& held, const Piece& piece);
  void add_shadows(Held& held, Piece& piece);
  void note_shadows(Receivers::Taken taken);
  void trace_and_draw();
  bool try_to_trace(const Batch& batch);
  bool trace(const Batch& batch);
  void count(const sideray_frame_stats& stats);
  void draw_held(Draws which, bool with_rays);
  void draw_both_ways();
  void draw_marks();
  void write_picture(const Picture& picture, const char* which) const;
  SceneDraw scene_draw(const Geometry& geometry, uint64_t hash, const DrawState& state);

  Rules rules_;
  Textures textures_;
  Survey survey_;
  Survey::Frame figures_;
  std::unique_ptr<SceneFile> capture_;  // of this frame, until it is written
  bool captured_ = false;
  std::unique_ptr<TracedScene> scene_;
  std::unique_ptr<Reflections> reflections_;
  std::vector<Held> held_;
  Receivers receivers_;
  // An opaque draw that is not in the scene yet, because the next draw may multiply a light map onto it.
  std::optional<Piece> pending_;
  float pending_tint_[4] = {};
  Matrix projection_{};
  std::array<GLint, 4> viewport_{};
  bool drew_opaque_ = false, flushing_ = false;
  bool tracing_ = false;     // frames have reflecting surfaces or shadows: opaque draws are captured
  bool casts_ = false;       // a draw is lit by the sun, and its shadows are not drawn yet
  bool holds_stencil_ = false;  // held draws test the stencil, and may write it
  bool compares_ = false;    // this frame is drawn both ways
  std::optional<Picture> start_;  // the picture before the first held draw of a frame that is drawn both ways
  int frames_without_ = 0;
  uint64_t number_ = 0;
  std::string ended_, renderer_;
  std::chrono::steady_clock::time_point reported_, began_;
};

}  // namespace sideray::run
