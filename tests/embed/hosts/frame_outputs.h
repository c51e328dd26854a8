// Submits frames through the C interface with their jobs by value, and reads the newest outputs of a view. Test
// support; on the thread that calls the service.
#pragma once

#include <algorithm>
#include <optional>
#include <sideray/sideray.hpp>

namespace sideray::tests {

inline sideray_status submit_frame(sideray_service* service, const FrameInputs& inputs, sideray_ticket& ticket,
                                   sideray_error* error = nullptr) {
  const sideray_frame_inputs frame = inputs.c();
  return sideray_service_submit(service, &frame, &ticket, error);
}

// Holds the outputs of one frame's jobs.
struct FrameOutputs {
  sideray_ticket ticket = 0;
  std::optional<sideray_layer_outputs> layers;
  std::optional<sideray_mask_outputs> masks;
  std::optional<sideray_reflection_outputs> reflections;
};

// Reads the newest outputs of one kind. A status that is an error goes to `status`.
template <typename Outputs>
std::optional<Outputs> newest_of_kind(sideray_service* service, uint32_t view_id,
                                      sideray_status (*read)(sideray_service*, uint32_t, Outputs*, sideray_error*),
                                      sideray_status& status) {
  Outputs outputs{};
  outputs.size = sizeof(outputs);
  const sideray_status own = read(service, view_id, &outputs, nullptr);
  if (own < 0) status = own;
  return own == SIDERAY_OK ? std::optional(outputs) : std::nullopt;
}

// Reads the newest outputs of every kind, which may be of different frames.
inline sideray_status newest_of_each_kind(sideray_service* service, uint32_t view_id, FrameOutputs& outputs) {
  sideray_status status = SIDERAY_OK;
  outputs.layers = newest_of_kind<sideray_layer_outputs>(service, view_id, sideray_service_layers, status);
  outputs.masks = newest_of_kind<sideray_mask_outputs>(service, view_id, sideray_service_masks, status);
  outputs.reflections =
      newest_of_kind<sideray_reflection_outputs>(service, view_id, sideray_service_reflections, status);
  outputs.ticket = std::max({outputs.layers ? outputs.layers->ticket : 0, outputs.masks ? outputs.masks->ticket : 0,
                             outputs.reflections ? outputs.reflections->ticket : 0});
  return status != SIDERAY_OK ? status : outputs.ticket == 0 ? SIDERAY_NOT_READY : SIDERAY_OK;
}

// Reads the outputs of the newest frame alone, without kinds that only older frames have.
inline sideray_status newest_outputs(sideray_service* service, uint32_t view_id, FrameOutputs& outputs) {
  const sideray_status status = newest_of_each_kind(service, view_id, outputs);
  if (outputs.layers && outputs.layers->ticket != outputs.ticket) outputs.layers.reset();
  if (outputs.masks && outputs.masks->ticket != outputs.ticket) outputs.masks.reset();
  if (outputs.reflections && outputs.reflections->ticket != outputs.ticket) outputs.reflections.reset();
  return status;
}

// Returns the outputs of a view; nothing before its first frame.
inline std::optional<FrameOutputs> newest_outputs(sideray_service* service, uint32_t view_id = 0) {
  FrameOutputs outputs;
  if (newest_outputs(service, view_id, outputs) != SIDERAY_OK) return std::nullopt;
  return outputs;
}

}  // namespace sideray::tests
