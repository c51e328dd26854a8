// Checks a caller's mesh and makes the dense form that readers rely on. Any thread.
#pragma once

#include <memory>

#include "model/snapshot.h"

namespace sideray::model {

// Throws Failure (INVALID_ARGUMENT). `dropped`, where not null, receives the number of triangles left out.
std::shared_ptr<const Mesh> build_mesh(const sideray_mesh_desc& desc, uint32_t* dropped);

}  // namespace sideray::model
