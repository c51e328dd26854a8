// What was submitted for a view, and what of it is answered: with `--late`, not the same.
#pragma once

#include <sideray/sideray.hpp>

#include <map>
#include <optional>

#include "preload/capture/draw_state.h"

namespace sideray::run {

// Where surfaces were in a frame that was submitted, by their names.
using Places = std::map<uint32_t, Matrix>;

struct Answers {
  std::optional<sideray_ticket> ticket;  // it is traced
  Places surfaces, receivers;            // of the ticket: what has layers, and what shadows fall on
  Places answered, shadowed;             // likewise, of the answers that are there
  sideray_frame_stats stats{};           // of these

  void submit(Service& service, const FrameInputs& inputs);
  // Takes the answers to the ticket if they are there within `timeout_ms`; -1 = waits for them.
  void take(Service& service, int32_t timeout_ms);
};

// Of a view whose world space is eye space; nothing is asked for yet, and all pixels count.
FrameInputs frame_inputs(uint32_t view, const Matrix& projection, const std::array<GLint, 4>& viewport);
// Of the sun alone, light 0 of the scene; `rounding`: how far off what OpenGL draws may be.
sideray_mask_inputs sun_masks(float rounding);
Service make_service(const Tracer& tracer);

}  // namespace sideray::run
