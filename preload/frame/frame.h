// One frame of the program after the other: its draws pass, become what rays see, or are held back until their rays are there.
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

// What is done with a draw, and the rule that says so.
struct Decision {
  Taking taking = Taking::left;
  Rule rule;
  bool is_seen = false;   // rays see it
  bool in_turn = false;   // it is kept only for the frame to be drawn both ways: it is no part of what waits for rays
  bool holds() const { return taking == Taking::reflects || taking == Taking::held || in_turn; }
};

inline constexpr float untinted[4] = {1, 1, 1, 1};

// A piece of a draw that is held back.
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

  // Before a draw. May draw what is held back, where this draw needs it done. `geometry`, `mesh`: null and 0 = not known yet.
  Decision decide(const DrawState& state, const Geometry* geometry, uint64_t mesh);
  // Whether the geometry of every draw is wanted, be it for what a rule or the report says of it.
  bool names_meshes() const { return rules_.has_meshes() || !settings().report.empty(); }
  // Whether the geometry of a draw is wanted.
  bool wants(const Decision& decision) const { return decision.holds() || (decision.is_seen && wants_scene()); }
  void show(Piece piece, const float tint[4]);
  // Holds a draw back: of arrays, or of a display list where `list` is not 0.
  void hold(std::vector<Piece> pieces, GLuint list, const float tint[4]);
  // The frame is drawn both ways: draws that are held back are made in their turn too, for the program's own picture.
  bool compares() const { return compares_; }
  // A draw that comes now cannot be held back: the frame is not drawn both ways.
  void compare_no_more();

  bool is_holding() const { return !held_.empty(); }
  // Whether something is drawn at the end of the frame: what is held back, or shadows.
  bool is_waiting() const { return is_holding() || !receivers_.empty() || casts_; }
  // Calls of the program that come meanwhile are those of another thread, in a signal handler as a rule.
  bool is_flushing() const { return flushing_; }
  // Draws shadows, and makes all draws that are held back.
  void flush();
  // At the swap.
  void end();
  // The context goes: `current` says whether it still can be used.
  void close(bool current);
  // From now on nothing is held back; the reason is said once.
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
    std::vector<Reflector> reflectors, bending;  // drawn after it and before it
    bool in_turn = false;
    bool in_shadow = false;  // shadows may fall on it

    HeldDraw draw() const;
  };
  enum class Draws { all, in_turn, waiting };
  // Where a surface is drawn in several stages, what it reflects is drawn over the last.
  void pass_on_reflectors(Held& next);
  bool is_later_stage(const Piece& piece) const;
  bool is_light_map_of_pending(const Piece& piece) const;
  void add_pending();
  void write_scene();
  Taking taking_of(const DrawState& state, const Rule& rule) const;
  bool has_other_view(const DrawState& state) const;
  // Whether the draw looks otherwise where what is held back is drawn after it.
  bool depends_on_held(const DrawState& state) const;
  bool wants_scene() const { return tracing_ && !settings().off; }
  // Blended draws wait, for shadows or for what they reflect.
  bool holds_later() const { return is_holding() || casts_; }
  bool is_lit_by_sun(const DrawState& state) const { return rules_.sun() >= 0 && state.lighting && Receivers::may_receive(state); }
  Batch batch() const;
  // Blended as it is, it hides what is behind it, but for holes of its texture.
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
  // An opaque draw that the scene has not got yet: the next draw may multiply a light map onto it.
  std::optional<Piece> pending_;
  float pending_tint_[4] = {};
  Matrix projection_{};
  std::array<GLint, 4> viewport_{};
  bool drew_opaque_ = false, flushing_ = false;
  bool tracing_ = false;     // frames have reflecting surfaces or shadows: opaque draws are captured
  bool casts_ = false;       // something has been drawn that the sun lights, and its shadows have not
  bool holds_stencil_ = false;  // what is held back tests the stencil, and may write it
  bool compares_ = false;    // this frame is drawn both ways
  std::optional<Picture> start_;  // before the first draw that is held back, where it is
  int frames_without_ = 0;
  uint64_t number_ = 0;
  std::string ended_, renderer_;
  std::chrono::steady_clock::time_point reported_, began_;
};

}  // namespace sideray::run
