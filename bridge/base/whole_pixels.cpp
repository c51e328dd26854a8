#include "bridge/base/whole_pixels.h"

namespace sideray::bridge {

NoWholePixels no_whole_pixels(bool counts, sideray_cache_rate rate, bool host_shades) {
  if (!counts) return {"no mask counts the surfaces of pixels, so that none is known to be whole", "mask"};
  if (rate != SIDERAY_RATE_FULL) return {"at a reduced rate no pixel is whole", "cache-rate"};
  if (host_shades) return {"covers of surfaces that a host shades are not known", "shader"};
  return {};
}

NoWholePixels no_whole_pixels(const sideray_translucency_options& o, bool host_shades) {
  if (o.oit == SIDERAY_OIT_PEEL) return {"peeling has a stencil of its own", "oit"};
  return no_whole_pixels(o.mask == SIDERAY_COUNT_MASK, o.cache_rate, host_shades);
}

}  // namespace sideray::bridge
