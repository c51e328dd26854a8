#include "rt/opaque/light_request.h"

#include <utility>

#include "model/failure.h"

namespace sideray::rt {

void check_light(const LightRequest& r, std::string_view name) {
  if (r.width == 0 || r.height == 0 || r.width > 65535 || r.height > 65535)
    fail(SIDERAY_INVALID_ARGUMENT, "{} of {}x{}: each side must be 1 to 65535", name, r.width, r.height);
  if (!r.depth.texels) fail(SIDERAY_INVALID_ARGUMENT, "{}: no depth; give a depth buffer", name);
}

MaskRequest depth_request(const LightRequest& r) {
  MaskRequest request{};
  request.view = r.view;
  request.width = r.width, request.height = r.height;
  request.depth = r.depth;
  request.subpixel = r.subpixel;
  request.points = r.points;
  return request;
}

FrameKey frame_key(const LightRequest& r, std::vector<std::byte> inputs) {
  FrameKey key;
  key.inputs = std::move(inputs);
  key.view = r.view;
  key.width = r.width;
  key.height = r.height;
  key.format = r.depth.format;
  key.seed = r.seed;
  key.position = r.position;
  key.shadows = r.shadows;
  key.subpixel = r.subpixel;
  return key;
}

}  // namespace sideray::rt
