// Decodes and encodes each image format in memory; other folders use images.h. Any thread.
#pragma once

#include "scenes/images/images.h"

namespace sideray::scenes {

// Throws Error where the size is zero or above the limits.
void check_image_size(uint64_t width, uint64_t height, const std::string& what);
// Does the same for a single picture of `channels` channels in floats.
void check_image_values(uint64_t channels, uint64_t width, uint64_t height, const std::string& what);
// Reserves the memory of `width` x `height` texels of RGBA8, and checks that there is room for the decoder's own
// `work_bytes` a texel. Without a budget there is no limit.
void take_texels(Budget* budget, uint64_t width, uint64_t height, uint64_t work_bytes, const std::string& what);

// Holds RGB or RGBA as authored: 8 or 16 bits, grey and palettes expanded, no colour management (glTF 2.0, 3.8.2).
struct PngPixels {
  uint32_t width = 0, height = 0, channels = 0, bits = 0;
  std::vector<uint8_t> samples;  // 16-bit samples in native byte order
};
PngPixels decode_png(std::span<const uint8_t> bytes, const std::string& what);
// Returns RGBA8, to which 16 bits are reduced.
Decoded decode_png_texels(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_png(std::span<const uint8_t> bytes);

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_jpeg(std::span<const uint8_t> bytes);
// Returns a JPEG of `quality` 1 to 100, with colours at half resolution; `rgb` as for write_png.
std::vector<uint8_t> encode_jpeg(uint32_t width, uint32_t height, std::span<const uint8_t> rgb, int quality,
                                 const std::string& what);

Decoded decode_webp(std::span<const uint8_t> bytes, const std::string& what, Budget* budget);
bool is_webp(std::span<const uint8_t> bytes);

Image read_exr(const std::string& path);
Image decode_hdr(std::span<const uint8_t> bytes, const std::string& what);

}  // namespace sideray::scenes
