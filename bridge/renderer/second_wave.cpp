#include "bridge/renderer/second_wave.h"

#include "bridge/renderer/trace_inputs.h"

namespace sideray::bridge {

rt::Counters trace_second_wave(const PictureJob& job, const FramePosition& position, const FirstWave& first,
                               FrameTimer& timer) {
  bool requested = false;
  timer.stage(SIDERAY_STAGE_MASK, [&] { requested = job.rasterizer.mask_asked(first.pass); });
  if (!requested) return {};
  FrameInputs inputs = trace_inputs(job, position);
  inputs.layers->adds_to = first.ticket;
  inputs.layers->requested_bits = gl::asked_stencil_bit;
  inputs.inspection.redraws = true;
  inputs.inspection.timed = timer.staged();
  const sideray_ticket ticket = job.service->submit(inputs);
  job.service->wait(ticket, SIDERAY_JOB_ALL, -1);
  rt::Counters wave = job.service->stats(ticket);
  timer.add(wave);
  // The wave's pixels, and their layers, are those that its frame has counted already.
  wave.pixels_total = wave.pixels_masked = wave.pixels_late = wave.pixels_older = wave.layers_requested = wave.dropped_particles = 0;
  return wave;
}

}  // namespace sideray::bridge
