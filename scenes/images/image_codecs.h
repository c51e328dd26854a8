// One function for each image format, bytes or planes in memory; images.h is what others use. Any thread.
#pragma once

#include "scenes/images/images.h"

namespace sideray::scenes {

// Throws Error where the size is zero or above the limits.
void check_image_size(uint64_t width, uint64_t height, const std::string& what);

// RGB or RGBA as authored: 8 or 16 bits, grey and palettes expanded, no colour management (glTF 2.0, 3.8.2).
struct PngPixels {
  uint32_t width = 0, height = 0, channels = 0, bits = 0;
  std::vector<uint8_t> samples;  // 16-bit samples in native byte order
};
PngPixels decode_png(std::span<const uint8_t> bytes, bool reduce_to_8_bits, const std::string& what);
bool is_png(std::span<const uint8_t> bytes);

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what);
bool is_jpeg(std::span<const uint8_t> bytes);
// `rgb` as for write_png; `quality` 1 to 100, colours at half resolution.
std::vector<uint8_t> encode_jpeg(uint32_t width, uint32_t height, std::span<const uint8_t> rgb, int quality,
                                 const std::string& what);

Decoded decode_webp(std::span<const uint8_t> bytes, const std::string& what);
bool is_webp(std::span<const uint8_t> bytes);

Image read_exr(const std::string& path);
Image decode_hdr(std::span<const uint8_t> bytes, const std::string& what);

}  // namespace sideray::scenes
