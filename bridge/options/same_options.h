// Says whether two pictures have equivalent options. Any thread.
#pragma once

#include <cstddef>
#include <cstring>

#include "bridge/base/render_options.h"

namespace sideray::bridge {

// Compares structs up to the end of their last member. They may have padding behind it, which holds anything, but not
// before.
template <typename T, typename Last>
bool same_through(Last T::*last, const T& a, const T& b) {
  const auto* begin = reinterpret_cast<const std::byte*>(&a);
  const auto bytes = static_cast<size_t>(reinterpret_cast<const std::byte*>(&(a.*last) + 1) - begin);
  return std::memcmp(&a, &b, bytes) == 0;
}

// Returns whether both draw the same picture of the same scene and view, apart from random numbers. Whether a picture
// continues, and how often it is repeated for its times, is not compared.
bool draw_alike(const RenderOptions& a, const RenderOptions& b);

}  // namespace sideray::bridge
