// Resolves the pointers of KHR_animation_pointer. One thread.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// The target of a pointer: "/materials/3/alphaCutoff" is the property "alphaCutoff" of material 3.
struct PointerTarget {
  enum class Kind { nothing, node, mesh, material, light, camera };
  Kind kind = Kind::nothing;
  size_t index = 0;
  std::string property;
};

// `kind` is `nothing` if the target is a property that Sideray does not animate. Throws Error if the pointer names an
// element that does not exist, or is malformed.
PointerTarget pointer_target(const File& file, const std::string& pointer, const std::string& user);

// Returns the count of numbers of a material's, light's or camera's property; 0 if Sideray does not have the property.
uint32_t numbers_of(const PointerTarget& target);

// Returns the materials whose thickness is among the animated `values`.
std::set<uint32_t> varying_thickness(std::span<const AnimatedValue> values);

// Adds the animated `values` to the rig. `materials`, `lights` and `cameras` link elements of the content with those of
// the file.
struct ReadThings {
  std::vector<ScaledMaterial> materials;
  std::vector<ReadThing> lights, cameras;
};
void animate_values(const File& file, std::span<const AnimatedValue> values, const ReadThings& read, Rig& rig,
                    Content& content);

}  // namespace sideray::scenes::gltf
