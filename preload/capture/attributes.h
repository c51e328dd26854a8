// Sets the attributes of immediate mode's next vertex.
#pragma once

#include <cstddef>
#include <limits>
#include <type_traits>

#include "preload/capture/geometry.h"

namespace sideray::run {

// Converts a component like glColor and glNormal: integers stand for 0..1 or -1..1.
template <typename T>
float normalized(T value) {
  if constexpr (std::is_floating_point_v<T>)
    return static_cast<float>(value);
  else if constexpr (std::is_unsigned_v<T>)
    return static_cast<float>(static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max()));
  else
    return static_cast<float>((2.0 * static_cast<double>(value) + 1.0) / (2.0 * static_cast<double>(std::numeric_limits<T>::max()) + 1.0));
}

template <int count, typename T>
void set_color(Vertex& vertex, const T* values) {
  vertex.color[3] = 1;
  for (int i = 0; i < count; ++i) vertex.color[i] = normalized(values[i]);
}

template <typename T>
void set_normal(Vertex& vertex, const T* values) {
  for (int i = 0; i < 3; ++i) vertex.normal[i] = normalized(values[i]);
}

// Sets four components from `count` values; missing ones become 0, 0 and 1.
template <int count, typename T>
void set_components(float (&target)[4], const T* values) {
  for (int i = 0; i < 4; ++i) target[i] = i < count ? static_cast<float>(values[i]) : i == 3 ? 1.0f : 0.0f;
}

// Queries the current attributes from OpenGL.
Vertex read_attributes();

}  // namespace sideray::run
