// Resolves the pointers of KHR_animation_pointer. One thread.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// Holds the target of a pointer: that of "/materials/3/alphaCutoff" is the property "alphaCutoff" of material 3.
struct PointerTarget {
  enum class Kind { nothing, node, mesh, material, light, camera };
  Kind kind = Kind::nothing;
  size_t index = 0;
  std::string property;
};

// Returns the target, whose `kind` is nothing where we do not animate the property. Throws Error where the text is no
// pointer or names a missing element.
PointerTarget pointer_target(const File& file, const std::string& pointer, const std::string& user);

// Returns how many numbers a value of a material, light or camera has; 0 for a property that we do not animate.
uint32_t numbers_of(const PointerTarget& target);

// Returns the materials whose thickness is among `values`.
std::set<uint32_t> varying_thickness(std::span<const AnimatedValue> values);

// Maps the file's materials, lights and cameras to those of the content, so that the rig can animate `values`.
struct ReadThings {
  std::vector<ScaledMaterial> materials;
  std::vector<ReadThing> lights, cameras;
};
void animate_values(const File& file, std::span<const AnimatedValue> values, const ReadThings& read, Rig& rig,
                    Content& content);

}  // namespace sideray::scenes::gltf
