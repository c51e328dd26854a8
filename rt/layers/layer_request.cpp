#include "rt/layers/layer_request.h"

#include <cstring>

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

bool ask_alike(const sideray_layer_inputs& a, const sideray_layer_inputs& b) {
  static_assert(sizeof(a) == sizeof(size_t) + sizeof(sideray_ticket) + 20 * sizeof(uint32_t),
                "padding would be compared too");
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

}  // namespace sideray::rt
