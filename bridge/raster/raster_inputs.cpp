#include "bridge/raster/raster_inputs.h"

#include "bridge/drawing/trace_inputs.h"

namespace sideray::bridge {

FrameInputs raster_inputs(const RasterParts& parts, const PictureJob& job, const FramePosition& position) {
  const gl::Rasterizer& rasterizer = parts.rasterizer;
  FrameInputs inputs = trace_inputs(job, position);
  inputs.source.framebuffer = rasterizer.framebuffer();
  if (job.plan.motion) inputs.source.motion_texture = rasterizer.motion_texture();
  if (job.plan.fills_rest) inputs.masks->rest_texture = rasterizer.rest_texture();
  if (job.plan.reflects) inputs.reflections->normal_texture = rasterizer.normal_texture();
  return inputs;
}

}  // namespace sideray::bridge
