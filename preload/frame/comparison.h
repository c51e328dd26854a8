// Compares the program's own picture of a frame with the ray-traced one: --pictures.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "preload/gl/entry_points.h"

namespace sideray::run {

// Holds colours, depth and stencil of a part of the framebuffer.
class Picture {
 public:
  explicit Picture(const std::array<GLint, 4>& viewport);
  // Writes them back into the framebuffer. Changes how pixels are unpacked, and no other state.
  void restore() const;
  bool write(const std::string& path) const;

 private:
  std::array<GLint, 4> viewport_;
  bool has_stencil_;
  std::vector<uint8_t> colors_, stencil_;
  std::vector<uint32_t> depth_;
};

}  // namespace sideray::run
