// One frame of the program after the other: its draws pass, become what rays see, or are held back until their rays are there.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "preload/base/rules.h"
#include "preload/base/settings.h"
#include "preload/capture/textures.h"
#include "preload/frame/scene_file.h"
#include "preload/frame/survey.h"
#include "preload/gl/saved_state.h"
#include "preload/rays/reflections.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

// What is done with a draw, and the rule that says so.
struct Decision {
  Taking taking = Taking::left;
  Rule rule;
  bool holds() const { return taking == Taking::reflects || taking == Taking::held; }
};

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

  // Before a draw. May draw what is held back, where this draw needs it done. `mesh`: 0 = not known yet.
  Decision decide(const DrawState& state, uint64_t mesh);
  // Whether opaque draws of this frame are wanted.
  bool wants_scene() const { return tracing_ && !settings().off; }
  void show(Piece piece, const float tint[4]);
  // Holds a draw back: of arrays, or of a display list where `list` is not 0.
  void hold(std::vector<Piece> pieces, GLuint list);

  bool is_holding() const { return !held_.empty(); }
  // Makes all draws that are held back.
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
    std::vector<Reflector> reflectors;
  };
  // Where a surface is drawn in several stages, what it reflects is drawn over the last.
  void pass_on_reflectors(Held& next);
  bool is_later_stage(const Piece& piece) const;
  bool is_light_map_of_pending(const Piece& piece) const;
  void add_pending();
  void write_scene();
  Taking taking_of(const DrawState& state, const Rule& rule) const;
  bool has_other_view(const DrawState& state) const;
  void trace_and_draw();
  bool trace();
  void draw_held(bool with_rays);
  void draw_both_ways();
  SceneDraw scene_draw(const Geometry& geometry, uint64_t hash, const DrawState& state);
  std::string picture_path(const char* which) const;

  Rules rules_;
  Textures textures_;
  Survey survey_;
  Survey::Frame figures_;
  std::unique_ptr<SceneFile> capture_;  // of this frame, until it is written
  bool captured_ = false;
  std::unique_ptr<TracedScene> scene_;
  std::unique_ptr<Reflections> reflections_;
  std::vector<Held> held_;
  // An opaque draw that the scene has not got yet: the next draw may multiply a light map onto it.
  std::optional<Piece> pending_;
  float pending_tint_[4] = {};
  Matrix projection_{};
  std::array<GLint, 4> viewport_{};
  bool drew_opaque_ = false, flushing_ = false;
  bool tracing_ = false;     // frames have reflecting surfaces: opaque draws are captured
  int frames_without_ = 0;
  uint64_t number_ = 0;
  std::string ended_, renderer_;
  std::chrono::steady_clock::time_point reported_;
};

}  // namespace sideray::run
