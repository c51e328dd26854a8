// What the pointers of KHR_animation_pointer lead to. One thread.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {

// "/materials/3/alphaCutoff": the property "alphaCutoff" of material 3.
struct PointerTarget {
  enum class Kind { nothing, node, mesh, material, light, camera };
  Kind kind = Kind::nothing;
  size_t index = 0;
  std::string property;
};

// `kind` is nothing where the pointer leads to what no animation of ours changes. Throws Error where it names an
// element that is not there, or is no pointer.
PointerTarget pointer_target(const File& file, const std::string& pointer, const std::string& user);

// How many numbers a value of a material, light or camera has; 0 where the property is none that we have.
uint32_t numbers_of(const PointerTarget& target);

// The materials whose thickness some of `values` change.
std::set<uint32_t> varying_thickness(std::span<const AnimatedValue> values);

// Gives the rig what `values` change. `materials`, `lights` and `cameras` say which of the content are those of the
// file.
struct ReadThings {
  std::vector<ScaledMaterial> materials;
  std::vector<ReadThing> lights, cameras;
};
void animate_values(const File& file, std::span<const AnimatedValue> values, const ReadThings& read, Rig& rig,
                    Content& content);

}  // namespace sideray::scenes::gltf
