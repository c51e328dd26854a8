#include "bridge/base/check_inputs.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "bridge/base/local_view.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

void check_rectangle(const sideray_frame_source& in) {
  if (in.width < 1 || in.height < 1 || in.width > 16384 || in.height > 16384 || in.x < 0 || in.y < 0)
    fail(SIDERAY_INVALID_ARGUMENT,
         "frame rectangle {}x{} at {},{}: sides must be 1 to 16384 and the corner not negative", in.width, in.height,
         in.x, in.y);
  if (in.depth_texture != 0 && in.depth_renderbuffer != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame depth_texture: there is a depth_renderbuffer too; give one of them");
  if (std::any_of(std::begin(in.reserved), std::end(in.reserved), [](uint32_t field) { return field != 0; }))
    fail(SIDERAY_UNSUPPORTED, "frame source reserved: it is not 0, and this version knows none of its fields; clear it");
}

void check_mask(const sideray_frame_source& in) {
  if (in.mask < SIDERAY_MASK_NONE || in.mask > SIDERAY_MASK_MEMORY)
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask {}: give a sideray_mask_source", static_cast<int>(in.mask));
  const bool contiguous = in.stencil_bits != 0 && in.stencil_bits <= 0xff && std::has_single_bit(in.stencil_bits + 1);
  if (reads_stencil_mask(in) && !contiguous)
    fail(SIDERAY_INVALID_ARGUMENT, "frame stencil_bits {:#x}: must be contiguous from bit 0, 0x1 to 0xff",
         in.stencil_bits);
  if (in.mask == SIDERAY_MASK_TEXTURE && in.mask_texture == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask_texture: 0; give the R8 texture that holds the mask");
  if (in.mask == SIDERAY_MASK_MEMORY && (!in.mask_texels || in.mask_row_bytes < static_cast<size_t>(in.width)))
    fail(SIDERAY_INVALID_ARGUMENT, "frame mask_texels: NULL, or rows of less than {} bytes; give a byte for each pixel",
         in.width);
}

}  // namespace

void check_frame(const FrameInputs& in) {
  if (jobs_of(in) == 0)
    fail(SIDERAY_INVALID_ARGUMENT, "frame: it has no job; give layers, masks, irradiance or reflections");
  check_rectangle(in.source);
  check_mask(in.source);
  if (!(in.deadline_ms >= 0.0f) || !std::isfinite(in.deadline_ms))
    fail(SIDERAY_INVALID_ARGUMENT, "frame deadline_ms {}: give finite milliseconds, or 0 for none", in.deadline_ms);
  if (!(in.budget_ms >= 0.0f) || !std::isfinite(in.budget_ms))
    fail(SIDERAY_INVALID_ARGUMENT, "frame budget_ms {}: give finite milliseconds, or 0 for none", in.budget_ms);
  if (in.budget_ms > 0.0f && in.deadline_ms > 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT, "frame budget_ms {}: there is a deadline_ms of {} too; give the budget alone",
         in.budget_ms, in.deadline_ms);
  if (in.state_policy < SIDERAY_SAVE_AND_RESTORE || in.state_policy > SIDERAY_HOST_RESTORES)
    fail(SIDERAY_INVALID_ARGUMENT, "frame state_policy {}: give a sideray_state_policy",
         static_cast<int>(in.state_policy));
  check_view_id(in.view_id);
  check_view(in.view);
}

void check_view_id(uint32_t id) {
  if (id >= SIDERAY_MAX_VIEWS) fail(SIDERAY_INVALID_ARGUMENT, "view_id {}: give 0 to {}", id, SIDERAY_MAX_VIEWS - 1);
}

}  // namespace sideray::bridge
