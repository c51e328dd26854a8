// Image files: PNG, OpenEXR, Radiance .hdr. Files are written whole or not at all. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scenes/base/budget.h"

namespace sideray::scenes {

struct Plane {
  enum class Type { half, single, uint };
  std::string name;                   // "R", "Z", "id.surface"
  Type type = Type::half;             // as stored in EXR
  std::vector<float> values;          // half and single
  std::vector<uint32_t> uint_values;  // uint
};

struct Image {
  uint32_t width = 0, height = 0;
  std::vector<Plane> planes;  // row 0 at the top
  bool linear = true;         // false: R, G, B are display values 0..1 (from a PNG)
  const Plane* find(const std::string& name) const;
};

// By extension: .png, .exr, .hdr. Throws Error naming the file, what is wrong and the remedy.
Image read_image(const std::string& path);

// Scanline, ZIP; data window = display window.
void write_exr(const std::string& path, const Image& image);

// `rgb`: 8 bits a channel, top row first, width * height * 3.
void write_png(const std::string& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb);

// The bytes of a PNG file; `channels` 3 (RGB) or 4 (RGBA), 8 bits each, top row first. `what` names it in an Error.
std::vector<uint8_t> encode_png(uint32_t width, uint32_t height, uint32_t channels, std::span<const uint8_t> pixels,
                                const std::string& what);

// Decodes PNG, JPEG or WebP bytes to RGBA8. Throws Error; `what` names the picture in it. `budget`, where there is one,
// gives the memory and the time, and is left without what the pixels take.
struct Decoded {
  uint32_t width, height;
  std::vector<uint8_t> rgba;
};
Decoded decode_image(std::span<const uint8_t> bytes, const std::string& what, Budget* budget = nullptr);

enum class Tonemap { none, reinhard, aces, aces_filmic, pbr_neutral };
inline constexpr const char* tonemap_names[] = {"none", "reinhard", "aces", "aces-filmic", "pbr-neutral"};  // by its values
// Throws Error where there is no such name.
Tonemap tonemap_named(const std::string& name);

// PNG values of a linear image (cli.md): sRGB_OETF(tonemap(2^ev * L)), unquantized, three floats a pixel. A display
// image comes back as it is.
std::vector<float> display_values(const Image& image, float exposure_ev, Tonemap tonemap);
// Round half up to 8 bits.
std::vector<uint8_t> quantize(std::span<const float> display);

}  // namespace sideray::scenes
