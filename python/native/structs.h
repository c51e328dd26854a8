// Converts structs of the C interface from dictionaries of their fields, and back. Absent fields get their defaults. An
// unknown field is an error, which lists the known ones.
#pragma once

#include "python/native/native.h"

namespace sideray::python {

sideray_light light_of(const py::dict& fields);
sideray_material_desc material_of(const py::dict& fields);
sideray_particles_desc particles_of(const py::dict& fields);

}  // namespace sideray::python
