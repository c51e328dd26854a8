// sideray_tracer_layered_depth: plain memory in, plain memory out.
#include <sideray/ground_truth.h>

#include "bridge/api/border.h"
#include "bridge/api/truth_view.h"
#include "bridge/base/handles.h"
#include "rt/truth/layered_depth.h"

using sideray::fail;
using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::read_struct;
using sideray::bridge::require;

namespace {

void check_desc(const sideray_layered_depth_desc& desc) {
  sideray::bridge::check_truth_size(desc.width, desc.height);
  if (desc.layers < 1 || desc.layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: out of range; give 1 to 64", desc.layers);
  if (desc.path != SIDERAY_LAYERS_STRAIGHT && desc.path != SIDERAY_LAYERS_BENT)
    fail(SIDERAY_INVALID_ARGUMENT, "path {}: unknown; give a sideray_layer_path", static_cast<int>(desc.path));
}

void trace(sideray_tracer& tracer, const sideray_layered_depth_desc& desc) {
  const sideray_camera camera = sideray::bridge::read_truth_camera(desc.camera);
  const auto lock = tracer.take_turn_in_call();
  tracer.use(tracer.committed());
  const auto view = sideray::bridge::truth_view(camera, desc.width, desc.height, tracer.snapshot->origin);
  tracer.tracer.trace_layered_depth({sideray::bridge::trace_view(view), sideray::bridge::depth_plane(view), desc});
}

}  // namespace

void sideray_layered_depth_init(sideray_layered_depth_desc* out, size_t size) {
  sideray_layered_depth_desc desc{};
  desc.width = 1280;
  desc.height = 720;
  desc.layers = 8;
  init_struct(out, size, desc);
}

sideray_status sideray_tracer_layered_depth(sideray_tracer* tracer, const sideray_layered_depth_desc* desc,
                                            sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    const sideray_layered_depth_desc read =
        read_struct(desc, "layered depth description", sideray_layered_depth_init);
    check_desc(read);
    trace(*tracer, read);
  });
}
