// Says why no pixel of a layer cache can be whole (docs/adr/0020-whole-pixels.md): the only place of this rule, for
// options, plan and hosts. Any thread.
#pragma once

#include <sideray/renderer.h>

namespace sideray::bridge {

// Static texts: the reason, and the option to change. Both null: pixels can be whole.
struct NoWholePixels {
  const char* reason = nullptr;
  const char* option = nullptr;
};

// `counts`: the mask counts the surfaces of each pixel.
NoWholePixels no_whole_pixels(bool counts, sideray_cache_rate rate, bool host_shades);
// Does the same for a picture, whose fragments also have an order.
NoWholePixels no_whole_pixels(const sideray_translucency_options& options, bool host_shades);

}  // namespace sideray::bridge
