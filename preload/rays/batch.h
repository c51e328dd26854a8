// What of a frame waits for rays together.
#pragma once

#include <array>
#include <vector>

#include "preload/gl/saved_state.h"
#include "preload/rays/receivers.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

// A surface that reflects.
struct Reflector {
  const Geometry* geometry = nullptr;
  Matrix modelview{};
  MirrorIds ids;
  float reflectance = 0;
  bool fresnel = true;  // it grows to 1 at grazing angles
};

// A draw that is held back, as it is made: of a display list, or of geometry.
struct HeldDraw {
  const SavedState* state = nullptr;
  GLuint list = 0;
  std::vector<const Geometry*> geometry;

  // Its state is set.
  void make() const;
};

struct Batch {
  uint32_t number = 0;  // of the frame's
  std::vector<Reflector> reflectors;
  std::vector<const SavedState*> states;  // of each reflector
  const Receivers* receivers = nullptr;
  std::vector<HeldDraw> shadowed;  // what is held back and lit by the sun
  int sun = 0;                     // GL_LIGHT0 + sun casts shadows
  Matrix projection{};
  std::array<GLint, 4> viewport{};

  bool has_shadows() const { return !receivers->draws().empty() && receivers->sun(); }  // on what is opaque
  bool is_empty() const { return reflectors.empty() && !has_shadows() && shadowed.empty(); }
};

}  // namespace sideray::run
