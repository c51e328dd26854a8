// Random numbers that are functions of their arguments. Any thread.
#pragma once

#include <cstdint>

namespace sideray::scenes {

// A fixed random number in [0, 1) of its arguments: the same everywhere.
float hash01(uint32_t a, uint32_t b = 0, uint32_t c = 0);

}  // namespace sideray::scenes
