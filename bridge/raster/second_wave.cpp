#include "bridge/raster/second_wave.h"

#include "bridge/raster/raster_inputs.h"

namespace sideray::bridge {

rt::Counters trace_second_wave(const RasterParts& parts, const PictureJob& job, const FramePosition& position,
                               const FirstWave& first, FrameTimer& timer) {
  Service& service = *parts.service;
  bool requested = false;
  timer.stage(SIDERAY_STAGE_MASK, [&] { requested = parts.rasterizer.mask_asked(first.pass); });
  if (!requested) return {};
  FrameInputs inputs = raster_inputs(parts, job, position);
  inputs.layers->adds_to = first.ticket;
  inputs.layers->requested_bits = gl::asked_stencil_bit;
  inputs.inspection.redraws = true;
  inputs.inspection.timed = timer.staged();
  const sideray_ticket ticket = service.submit(inputs);
  wait_for(service, job, ticket, SIDERAY_JOB_ALL);
  rt::Counters wave = service.stats(ticket);
  timer.add(wave);
  // The first wave's statistics already include these.
  wave.pixels_total = wave.pixels_masked = wave.pixels_late = wave.pixels_older = wave.layers_requested = wave.dropped_particles = 0;
  return wave;
}

}  // namespace sideray::bridge
