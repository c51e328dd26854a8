// Encodes pictures as text inside a page, each small enough for the page to stay small. Plain memory; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"

namespace sideray::lab {

// Says how large `pictures` pictures of `width` x `height` may be for a page of some megabytes.
struct PageScale {
  uint32_t width = 0, height = 0;
  size_t most_bytes = 0;  // of one picture, before base64
  bool is_exact = false;  // pictures keep their size and lose nothing
};
PageScale page_scale(uint32_t width, uint32_t height, size_t pictures);

// Holds a picture and its difference from the reference, as data URIs.
struct PagePicture {
  std::string picture;
  std::optional<std::string> map;  // FLIP in false colours; empty with pixels that are not finite
};

std::string page_picture(const scenes::Image& image, const Display& display, const PageScale& scale);
PagePicture page_picture(const scenes::Image& image, const scenes::Image& reference, const Display& display,
                         const PageScale& scale);

// Both return 8-bit RGB, three bytes a pixel, as a data URI; png_uri() keeps it as it is.
std::string png_uri(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height);
std::string page_map(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height, const PageScale& scale);

}  // namespace sideray::lab
