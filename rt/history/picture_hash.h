// Hashes the input pictures of a frame, so that frames are compared without storing them. Any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "rt/base/executor.h"
#include "rt/base/view.h"

namespace sideray::rt {

using PictureHash = std::array<uint64_t, 4>;

// Hashes the depth and the given stencil bits. Bits that the format leaves undefined are ignored.
PictureHash hash_depth(Executor& executor, const DepthImage& depth, uint32_t width, uint32_t height, uint32_t stencil_bits);
// Hashes rows of equal size.
PictureHash hash_rows(Executor& executor, std::span<const std::byte> texels, uint32_t rows);

}  // namespace sideray::rt
