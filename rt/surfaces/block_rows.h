// Declares what all kernels that process sixteen hits at a time share. Plain arrays; any thread may use them.
#pragma once

#include <stdint.h>

namespace sideray::rt {

inline constexpr uint32_t block_size = 16;

// Holds one value of each hit of a block. Its owner aligns it to 64 bytes.
using BlockRow = float[block_size];

// Refers to texels of three floats; width 0: black.
struct TexelView {
  const float* texels;
  int32_t width, height;
};

}  // namespace sideray::rt
