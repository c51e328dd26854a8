// Holds the draws of a frame that receive the sun's shadows: the draws that it lights, and others that rules name.
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
  float shade = 1;       // the share of its colour that shadows leave, if it is not lit
  uint32_t name = 0;     // the same from frame to frame
};

class Receivers {
 public:
  void begin_frame();
  // Forgets the draws so far, because they have their shadows.
  void clear() { draws_.clear(), held_.clear(); }
  // Says what becomes of a draw: it receives shadows; it receives none; or it receives none because the sun lights it
  // from another place than earlier draws.
  enum class Taken { receives, nothing, other_sun };
  // Takes an opaque draw if GL_LIGHT0 + `sun` lights it, or if the rule has a shade for it.
  Taken add(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture, const Rule& rule,
            int sun);
  // Takes a draw that is held back, if GL_LIGHT0 + `sun` lights it.
  Taken hold(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture, int sun);
  // Returns whether add() may take the draw.
  static bool may_receive(const DrawState& state) { return has_place(state) && state.depth_write; }

  bool empty() const { return draws_.empty() && held_.empty(); }
  const std::vector<Receiver>& draws() const { return draws_; }
  const std::vector<Receiver>& held() const { return held_; }
  // Returns this frame's sun, in eye space; null until a lit draw says where it is.
  const FixedLight* sun() const { return sun_ ? &*sun_ : nullptr; }
  // Returns how far off OpenGL's positions may be, because it rounds coordinates far from their origin. Rays use eye
  // space, whose origin is the eye.
  float rounding() const { return 1.9e-6f * farthest_origin_; }  // 2^-19

 private:
  static bool has_place(const DrawState& state) {
    return state.is_perspective() && state.depth_test && state.writes_color && state.whole_depth_range;
  }
  // Returns the draw with its lights; without, if the sun does not light it or stands elsewhere.
  Receiver lit(const DrawState& state, int sun, Taken& taken);
  void keep(std::vector<Receiver>& list, Receiver draw, const DrawState& state,
            std::shared_ptr<const Geometry> geometry, uint64_t texture);

  std::vector<Receiver> draws_, held_;
  std::optional<FixedLight> sun_;
  float farthest_origin_ = 0;  // of a draw's own coordinates, from the eye
  SurfaceNames names_;
};

}  // namespace sideray::run
