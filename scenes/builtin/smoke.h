// Paints flip-books of smoke and flames by code, for the built-in scenes with particles. Any thread.
#pragma once

#include <cstdint>

#include "scenes/content/shapes.h"

namespace sideray::scenes {

// Both return the index + 1 of the texture: 4 x 4 grey puffs that fray, and 4 x 4 pictures in a loop of a flickering
// flame, bright on black.
uint32_t paint_smoke(ContentBuilder& b);
uint32_t paint_flame(ContentBuilder& b);
inline constexpr uint32_t flip_book_columns = 4, flip_book_rows = 4;

}  // namespace sideray::scenes
