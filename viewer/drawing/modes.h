// Modes of display: a picture's colours, or one of its other channels in false colours. Any thread.
#pragma once

#include <cstdint>
#include <sideray/sideray.hpp>
#include <span>
#include <vector>

namespace sideray::viewer {

enum class Coloring : uint8_t { color, direction, distance, share, number, count, offset, age };

struct Mode {
  const char* name;
  const char* group;    // the subject that it belongs to
  uint32_t aov;         // a SIDERAY_AOV_* bit; 0: the colours themselves
  const char* channel;  // "Z"; for N.X, N.Y, N.Z the part before the dot: "N"
  Coloring coloring;
  bool is_lit;  // the channel exists only if colours are drawn, too
};

// Explains the colours of ages.
constexpr const char* age_legend = "green: traced for this picture, yellow to red: earlier, violet: as without rays, black: asks for none";

// Returns all modes; the first one shows the colours.
std::span<const Mode> modes();

// Returns three bytes a pixel, top row first; empty if the picture has no such channel.
std::vector<uint8_t> shown(const Picture& picture, const Mode& mode);

// Return the channel of that name; NULL if the picture has none.
const float* floats_of(const Picture& picture, const char* name);
const uint32_t* numbers_of(const Picture& picture, const char* name);

}  // namespace sideray::viewer
