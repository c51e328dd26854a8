#include "bridge/plan/rays_alone.h"

#include "model/failure.h"

namespace sideray::bridge {

void check_rays_alone(const RenderOptions& o) {
  if (o.is_reference) return;
  if (o.draws(SIDERAY_TRANSLUCENCY_RASTER) || (o.is_hybrid() && o.translucency.layers == 0))
    fail(SIDERAY_UNSUPPORTED, "translucency raster without OpenGL: blended fragments are rasterized; choose hybrid, raytraced "
                              "or off, or draw with OpenGL");
  if (o.translucency.check)
    fail(SIDERAY_UNSUPPORTED, "layers are checked against fragments, and without OpenGL there are none; leave the check out");
  if (o.shows(SIDERAY_AOV_LAYERS))
    fail(SIDERAY_UNSUPPORTED, "layers to show: without OpenGL translucent surfaces are composited along their rays, and no "
                              "layers are kept; leave them out, or draw with OpenGL");
}

}  // namespace sideray::bridge
