// What of a picture is shown: its colours, or one of its other channels in colours that tell values apart. Any thread.
#pragma once

#include <cstdint>
#include <sideray/sideray.hpp>
#include <span>
#include <vector>

namespace sideray::viewer {

enum class Coloring : uint8_t { color, direction, distance, share, number, count, offset, age };

struct Mode {
  const char* name;
  const char* group;    // what it tells of
  uint32_t aov;         // a SIDERAY_AOV_* bit; 0: the colours themselves
  const char* channel;  // "Z"; of several the name without what is behind the last dot: "N"
  Coloring coloring;
  bool is_lit;  // it is found while colours are drawn, and not without
};

// What the colours of ages mean.
constexpr const char* age_legend = "green: traced for this picture, yellow to red: earlier, violet: as without rays, black: asks for none";

// The first one is the colours.
std::span<const Mode> modes();

// Three bytes a pixel, top row first; empty where the picture has no such channel.
std::vector<uint8_t> shown(const Picture& picture, const Mode& mode);

// The channel of that name as floats; NULL where the picture has none.
const float* floats_of(const Picture& picture, const char* name);
const uint32_t* numbers_of(const Picture& picture, const char* name);

}  // namespace sideray::viewer
