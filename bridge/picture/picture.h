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

// Calls visit(i, y * width + x) for each pixel in the order of planes: i counts from the top row, y from the bottom.
template <typename Visit>
void for_each_texel(const Picture& picture, Visit&& visit) {
  size_t i = 0;
  for (uint32_t row = picture.height; row-- > 0;)
    for (uint32_t x = 0; x < picture.width; ++x) visit(i++, size_t{row} * picture.width + x);
}

inline void append(Picture& picture, Picture::Plane plane) {
  const Picture::Plane& kept =
      *picture.planes.emplace_back(std::make_shared<const Picture::Plane>(std::move(plane)));
  if (kept.values.empty())
    picture.channels.push_back({kept.name.c_str(), SIDERAY_CHANNEL_UINT, kept.uint_values.data()});
  else
    picture.channels.push_back({kept.name.c_str(), SIDERAY_CHANNEL_FLOAT, kept.values.data()});
}

// Appends a plane whose value at pixel (x, y), y counted from the bottom, is value(y * width + x).
template <typename Value>
void add_plane(Picture& picture, std::string name, Value&& value) {
  Picture::Plane plane{std::move(name), {}, {}};
  constexpr bool integral = std::is_integral_v<decltype(value(size_t{0}))>;
  const size_t count = size_t{picture.width} * picture.height;
  const auto fill = [&](auto& values) {
    values.resize(count);
    for_each_texel(picture, [&, to = values.data()](size_t i, size_t texel) { to[i] = value(texel); });
  };
  if constexpr (integral)
    fill(plane.uint_values);
  else
    fill(plane.values);
  append(picture, std::move(plane));
}

// Fills all four planes at once, because memory bandwidth limits it.
inline void add_color(Picture& picture, const std::vector<glm::vec4>& color) {
  Picture::Plane planes[] = {{"R", {}, {}}, {"G", {}, {}}, {"B", {}, {}}, {"A", {}, {}}};
  for (Picture::Plane& plane : planes) plane.values.resize(color.size());
  for_each_texel(picture, [&, r = planes[0].values.data(), g = planes[1].values.data(), b = planes[2].values.data(),
                           a = planes[3].values.data()](size_t i, size_t texel) {
    const glm::vec4 c = color[texel];
    r[i] = c.x, g[i] = c.y, b[i] = c.z, a[i] = c.w;
  });
  for (Picture::Plane& plane : planes) append(picture, std::move(plane));
}

// Adds three planes with the components of value(texel).
template <typename Value>
void add_vectors(Picture& picture, const char* prefix, const char* const (&suffixes)[3], Value&& value) {
  for (int c = 0; c < 3; ++c)
    add_plane(picture, std::string(prefix) + suffixes[c], [&](size_t i) { return float{value(i)[c]}; });
}

}  // namespace sideray::bridge
