#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 16384
#include <stb_image.h>

#include <algorithm>
#include <climits>
#include <memory>

#include "scenes/files.h"
#include "scenes/image_codecs.h"

namespace sideray::scenes {
namespace {

struct FreeStb {
  void operator()(void* pixels) const { stbi_image_free(pixels); }
};

int stb_size(std::span<const uint8_t> bytes, const std::string& what) {
  if (bytes.size() > INT_MAX) refuse("cannot read {}: it has more than 2 GiB; use a smaller picture", what);
  return static_cast<int>(bytes.size());
}

void check_stb_size(std::span<const uint8_t> bytes, const std::string& what) {
  int width = 0, height = 0, channels = 0;
  if (stbi_info_from_memory(bytes.data(), stb_size(bytes, what), &width, &height, &channels) == 0) {
    refuse("cannot read {}: {}; write the file again", what, stbi_failure_reason());
  }
  check_image_size(static_cast<uint64_t>(width), static_cast<uint64_t>(height), what);
}

}  // namespace

bool is_jpeg(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what) {
  // stb_image fills what is missing with grey; a JPEG that was cut lacks its end marker.
  static constexpr uint8_t end_of_image[] = {0xff, 0xd9};
  if (std::search(bytes.rbegin(), bytes.rend(), std::rbegin(end_of_image), std::rend(end_of_image)) == bytes.rend()) {
    refuse("cannot read {}: the file ends too early; write the file again", what);
  }
  check_stb_size(bytes, what);
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, FreeStb> pixels(
      stbi_load_from_memory(bytes.data(), stb_size(bytes, what), &width, &height, &channels, 4));
  if (!pixels) refuse("cannot read {}: {}; write the file again", what, stbi_failure_reason());
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height) * 4;
  return {static_cast<uint32_t>(width), static_cast<uint32_t>(height), {pixels.get(), pixels.get() + count}};
}

}  // namespace sideray::scenes
