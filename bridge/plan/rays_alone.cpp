#include "bridge/plan/rays_alone.h"

#include "model/failure.h"

namespace sideray::bridge {

void check_rays_alone(const RenderOptions& o) {
  if (o.is_reference) return;
  if (o.translucency.check)
    fail(SIDERAY_UNSUPPORTED, "layers are checked against fragments, and without OpenGL there are none; leave the check out");
}

}  // namespace sideray::bridge
