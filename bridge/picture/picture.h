// Holds the result of a render: named planes, top row first, statistics and times. Any thread.
#pragma once

#include <sideray/renderer.h>

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "bridge/picture/stages.h"

struct sideray_picture {
  sideray_picture() = default;
  sideray_picture(uint32_t of_width, uint32_t of_height) : width(of_width), height(of_height) {
    stats.size = sizeof(stats);
  }

  struct Plane {
    std::string name;
    std::vector<float> values;
    std::vector<uint32_t> uint_values;  // used instead of `values`, for ids and counts
  };
  uint32_t width = 0, height = 0;
  std::vector<std::shared_ptr<const Plane>> planes;  // channels point into them; copies of a picture share them
  std::vector<sideray_channel> channels;
  sideray_render_stats stats{};
  sideray::bridge::StageTimes stages;
};

namespace sideray::bridge {

using Picture = sideray_picture;

// Appends a plane whose value at pixel (x, y), y counted from the bottom, is value(y * width + x).
template <typename Value>
void add_plane(Picture& picture, std::string name, Value&& value) {
  Picture::Plane plane{std::move(name), {}, {}};
  constexpr bool integral = std::is_integral_v<decltype(value(size_t{0}))>;
  const size_t count = size_t{picture.width} * picture.height;
  if constexpr (integral)
    plane.uint_values.reserve(count);
  else
    plane.values.reserve(count);
  for (uint32_t row = picture.height; row-- > 0;)
    for (uint32_t x = 0; x < picture.width; ++x) {
      const size_t texel = size_t{row} * picture.width + x;
      if constexpr (integral)
        plane.uint_values.push_back(value(texel));
      else
        plane.values.push_back(value(texel));
    }
  const Picture::Plane& kept =
      *picture.planes.emplace_back(std::make_shared<const Picture::Plane>(std::move(plane)));
  if constexpr (integral)
    picture.channels.push_back({kept.name.c_str(), SIDERAY_CHANNEL_UINT, kept.uint_values.data()});
  else
    picture.channels.push_back({kept.name.c_str(), SIDERAY_CHANNEL_FLOAT, kept.values.data()});
}

inline void add_color(Picture& picture, const std::vector<glm::vec4>& color) {
  const char* const names[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 4; ++c) add_plane(picture, names[c], [&](size_t i) { return color[i][c]; });
}

// Adds three planes with the components of value(texel).
template <typename Value>
void add_vectors(Picture& picture, const char* prefix, const char* const (&suffixes)[3], Value&& value) {
  for (int c = 0; c < 3; ++c)
    add_plane(picture, std::string(prefix) + suffixes[c], [&](size_t i) { return float{value(i)[c]}; });
}

}  // namespace sideray::bridge
