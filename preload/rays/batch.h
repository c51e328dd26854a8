// The draws of a frame that wait together for rays.
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
  bool fresnel = true;  // the reflectance grows to 1 at grazing angles
};

// Holds a draw that is held back: a display list, or geometry.
struct HeldDraw {
  const SavedState* state = nullptr;
  GLuint list = 0;
  std::vector<const Geometry*> geometry;

  // Draws; `state` must be set.
  void make() const;
};

struct Batch {
  uint32_t number = 0;  // within the frame
  std::vector<Reflector> reflectors;
  std::vector<const SavedState*> states;  // of each reflector
  const Receivers* receivers = nullptr;
  std::vector<HeldDraw> shadowed;  // held draws that the sun lights
  int sun = 0;                     // GL_LIGHT0 + sun casts shadows
  Matrix projection{};
  std::array<GLint, 4> viewport{};

  bool has_shadows() const { return !receivers->draws().empty() && receivers->sun(); }  // on opaque draws
  bool is_empty() const { return reflectors.empty() && !has_shadows() && shadowed.empty(); }
};

}  // namespace sideray::run
