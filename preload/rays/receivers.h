// The draws of a frame on which the sun's shadows fall: those that it lights, and what rules say of others.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "preload/base/rules.h"
#include "preload/capture/draw_state.h"
#include "preload/rays/surface_names.h"

namespace sideray::run {

struct Receiver {
  std::shared_ptr<const Geometry> geometry;
  Matrix modelview{};
  std::shared_ptr<const Lighting> lights;  // null = `shade` counts
  DrawMaterial material;
  Fog fog;
  bool colored = false;  // the vertices' colours are the material's
  float shade = 1;       // what shadows leave of its colour, where it is not lit
  uint32_t name = 0;     // the same from frame to frame
};

class Receivers {
 public:
  void begin_frame();
  // The draws so far have their shadows.
  void clear() { draws_.clear(), held_.clear(); }
  // What becomes of a draw: shadows fall on it, it is none on which they fall, or the sun lights it from another place than those
  // before, which nothing is done about.
  enum class Taken { receives, nothing, other_sun };
  // Takes an opaque draw if GL_LIGHT0 + `sun` lights it, or the rule says what shadows leave of it.
  Taken add(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture, const Rule& rule, int sun);
  // Takes a draw that is held back, if that light lights it.
  Taken hold(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture, int sun);
  // Whether add() may take it.
  static bool may_receive(const DrawState& state) { return has_place(state) && state.depth_write; }

  bool empty() const { return draws_.empty() && held_.empty(); }
  const std::vector<Receiver>& draws() const { return draws_; }
  const std::vector<Receiver>& held() const { return held_; }
  // Of this frame, in eye space; null until a lit draw says where it is.
  const FixedLight* sun() const { return sun_ ? &*sun_ : nullptr; }
  // How far off what OpenGL draws may be, by the rounding of coordinates far from their origin: eye space, which rays know, is
  // around the eye.
  float rounding() const { return 1.9e-6f * farthest_origin_; }  // 2^-19

 private:
  static bool has_place(const DrawState& state) {
    return state.is_perspective() && state.depth_test && state.writes_color && state.whole_depth_range;
  }
  // The draw as the sun lights it; without lights where it does not, or stands elsewhere.
  Receiver lit(const DrawState& state, int sun, Taken& taken);
  void keep(std::vector<Receiver>& list, Receiver draw, const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture);

  std::vector<Receiver> draws_, held_;
  std::optional<FixedLight> sun_;
  float farthest_origin_ = 0;  // of a draw's own coordinates, from the eye
  SurfaceNames names_;
};

}  // namespace sideray::run
