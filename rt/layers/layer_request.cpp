#include "rt/layers/layer_request.h"

namespace sideray::rt {

sideray_layer_inputs default_layer_inputs() {
  sideray_layer_inputs in{};
  in.size = sizeof(in);
  in.max_layers = 4;
  in.match_threshold = 0.001f;
  in.radiance_scale = 1.0f;
  in.denoise = 1;
  in.bounces = 1;
  return in;
}

}  // namespace sideray::rt
