// Checks instances and lights, and places them in the local space of a snapshot. Any thread may call it.
#pragma once

#include <cstddef>
#include <vector>

#include "model/snapshot.h"

namespace sideray::model {

// Throw Failure (INVALID_ARGUMENT) that names the fault of the element `index`.
void check_transform(const double* world_from_object, size_t index);
void check_light(const sideray_light& light, size_t index);

// Holds the input of sideray_scene_set_fixed_function(); `desc` does not refer to its lights.
struct FixedDesc {
  sideray_fixed_function desc;
  std::vector<sideray_fixed_light> lights;
};
// Throws Failure (INVALID_ARGUMENT) that names the field.
void check_fixed_function(const FixedDesc& model);

// Chooses the origin: the middle of world positions, on a grid so coarse that it is 0 for every scene near the world's
// origin, and rarely changes when something is moved or added.
class OriginChoice {
 public:
  void add(const double* world_from_object);
  glm::dvec3 origin() const;

 private:
  glm::dvec3 low_{INFINITY}, high_{-INFINITY};
};

// Set everything but mesh and material, whose indices the snapshot decides.
Instance local_instance(const sideray_instance_desc& desc, glm::dvec3 origin, const Mesh& mesh, const Wind* wind);
Light local_light(const sideray_light& light, glm::dvec3 origin);
FixedFunction local_fixed_function(const FixedDesc& model, glm::dvec3 origin);

}  // namespace sideray::model
