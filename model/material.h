// What is derived from a material, decided in one place for rasterizer, tracer, plan and hosts. Any thread.
#pragma once

#include <sideray/scene.h>

namespace sideray::model {

// White, rough, opaque, ior 1.5, no textures: sideray_material_init.
sideray_material_desc default_material();

}  // namespace sideray::model
