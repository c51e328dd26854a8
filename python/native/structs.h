// Structs of the C interface from dictionaries of their fields, and back. Fields that are not given have their defaults; one
// that is not there is refused, and the message lists those that are.
#pragma once

#include "python/native/native.h"

namespace sideray::python {

sideray_light light_of(const py::dict& fields);
sideray_material_desc material_of(const py::dict& fields);
sideray_particles_desc particles_of(const py::dict& fields);

}  // namespace sideray::python
