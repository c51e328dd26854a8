// Declares one function for each image format, on bytes or planes in memory; other code uses images.h. Any thread.
#pragma once

#include "scenes/images/images.h"

namespace sideray::scenes {

// Throws Error if the size is zero or above the limits.
void check_image_size(uint64_t width, uint64_t height, const std::string& what);
// Throws Error if the values of all `channels` of a separate picture, stored as floats, exceed the limits.
void check_image_values(uint64_t channels, uint64_t width, uint64_t height, const std::string& what);
// Takes the memory of `width` x `height` RGBA8 texels from the budget, and checks that decoding fits too, which needs
// `work_bytes` more for each texel. Without a budget there is no limit.
void take_texels(Budget* budget, uint64_t width, uint64_t height, uint64_t work_bytes, const std::string& what);

// Holds RGB or RGBA as authored: 8 or 16 bits, grey and palettes expanded, no colour management (glTF 2.0, 3.8.2).
struct PngPixels {
  uint32_t width = 0, height = 0, channels = 0, bits = 0;
  std::vector<uint8_t> samples;  // 16-bit samples in native byte order
};
PngPixels decode_png(std::span<const uint8_t> bytes, const std::string& what);
// Returns RGBA8; 16-bit samples are reduced.
Decoded decode_png_texels(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_png(std::span<const uint8_t> bytes);

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_jpeg(std::span<const uint8_t> bytes);
// Takes `rgb` like write_png(); `quality` is 1 to 100. Chroma is stored at half resolution.
std::vector<uint8_t> encode_jpeg(uint32_t width, uint32_t height, std::span<const uint8_t> rgb, int quality,
                                 const std::string& what);

Decoded decode_webp(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_webp(std::span<const uint8_t> bytes);

Image read_exr(const std::string& path);
Image decode_hdr(std::span<const uint8_t> bytes, const std::string& what);

}  // namespace sideray::scenes
