// Reads and writes image files: PNG, OpenEXR, Radiance .hdr. Files are written whole or not at all. Any thread.
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

// Reads an image by its extension: .png, .exr, .hdr. Throws Error, which names the file, the cause and the remedy.
Image read_image(const std::string& path);

// Writes scanlines with ZIP compression; the data window is the display window.
void write_exr(const std::string& path, const Image& image);

// Writes `rgb`: 8 bits a channel, top row first, width * height * 3.
void write_png(const std::string& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb);

// Returns the bytes of a PNG file of `channels` 3 (RGB) or 4 (RGBA), 8 bits each, top row first. `what` names it in an
// Error.
std::vector<uint8_t> encode_png(uint32_t width, uint32_t height, uint32_t channels, std::span<const uint8_t> pixels,
                                const std::string& what);

// Decodes PNG, JPEG or WebP bytes to RGBA8. Throws Error, in which `what` names the picture. `budget`, if any, limits
// time and memory, and the pixels are taken from it.
struct Decoded {
  uint32_t width, height;
  std::vector<uint8_t> rgba;
};
Decoded decode_image(std::span<const uint8_t> bytes, const std::string& what, Budget* budget = nullptr);

enum class Tonemap { none, reinhard, aces, aces_filmic, pbr_neutral };
inline constexpr const char* tonemap_names[] = {"none", "reinhard", "aces", "aces-filmic", "pbr-neutral"};  // by value
// Returns the tone map of this name. Throws Error where there is none.
Tonemap tonemap_named(const std::string& name);

// Returns the PNG values of a linear image (cli.md): sRGB_OETF(tonemap(2^ev * L)), unquantized, three floats a pixel.
// Those of a display image are its own.
std::vector<float> display_values(const Image& image, float exposure_ev, Tonemap tonemap);
// Rounds half up to 8 bits.
std::vector<uint8_t> quantize(std::span<const float> display);

}  // namespace sideray::scenes
