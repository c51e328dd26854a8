// Holds what was submitted for a view and what is answered; with `--late` the answers are of an earlier frame.
#pragma once

#include <sideray/sideray.hpp>

#include <map>
#include <optional>

#include "preload/capture/draw_state.h"

namespace sideray::run {

// Holds where the surfaces were in a submitted frame, by their names.
using Places = std::map<uint32_t, Matrix>;

struct Answers {
  std::optional<sideray_ticket> ticket;  // of the frame that is being traced
  Places surfaces, receivers;            // in the ticket's frame: surfaces with layers, and receivers of shadows
  Places answered, shadowed;             // the same in the frame of the answers
  sideray_frame_stats stats{};           // of the answers

  void submit(Service& service, const FrameInputs& inputs);
  // Takes the ticket's answers if they arrive within `timeout_ms`; -1 = waits for them.
  void take(Service& service, int32_t timeout_ms);
};

// Returns inputs for a view whose world space is eye space, without a stencil mask.
FrameInputs frame_inputs(uint32_t view, const Matrix& projection, const std::array<GLint, 4>& viewport);
// Returns inputs for masks of the sun alone, light 0 of the scene. `rounding`: error of the positions OpenGL draws.
sideray_mask_inputs sun_masks(float rounding);
Service make_service(const Tracer& tracer);

}  // namespace sideray::run
