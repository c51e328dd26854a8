// Convert structs of the C interface from and to dictionaries of their fields. Missing fields get their defaults; an
// unknown field is an error, whose message lists the known ones.
#pragma once

#include "python/native/native.h"

namespace sideray::python {

sideray_light light_of(const py::dict& fields);
sideray_material_desc material_of(const py::dict& fields);
sideray_particles_desc particles_of(const py::dict& fields);

}  // namespace sideray::python
