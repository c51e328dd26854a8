#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#include <stb_image.h>

#include <algorithm>
#include <climits>
#include <cstring>
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

// stb_image takes missing bytes for zeros. A request that gets nothing at all is one behind the end of the file.
struct ByteStream {
  std::span<const uint8_t> bytes;
  size_t position = 0;
  bool passed_end = false;

  static int read(void* user, char* to, int size) {
    auto& stream = *static_cast<ByteStream*>(user);
    const size_t count = std::min(static_cast<size_t>(size), stream.bytes.size() - stream.position);
    if (count == 0) stream.passed_end = true;
    std::memcpy(to, stream.bytes.data() + stream.position, count);
    stream.position += count;
    return static_cast<int>(count);
  }
  static void skip(void* user, int count) {
    auto& stream = *static_cast<ByteStream*>(user);
    stream.position = std::min(stream.bytes.size(), stream.position + static_cast<size_t>(count));
  }
  static int at_end(void* user) {
    const auto& stream = *static_cast<ByteStream*>(user);
    return stream.position == stream.bytes.size() ? 1 : 0;
  }
};

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

Image decode_hdr(std::span<const uint8_t> bytes, const std::string& what) {
  if (stbi_is_hdr_from_memory(bytes.data(), stb_size(bytes, what)) == 0) {
    refuse("cannot read {}: it is not a Radiance .hdr file; check what wrote it", what);
  }
  check_stb_size(bytes, what);
  ByteStream stream{bytes};
  const stbi_io_callbacks callbacks{ByteStream::read, ByteStream::skip, ByteStream::at_end};
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<float, FreeStb> texels(
      stbi_loadf_from_callbacks(&callbacks, &stream, &width, &height, &channels, 3));
  if (!texels) refuse("cannot read {}: {}; write the file again", what, stbi_failure_reason());
  if (stream.passed_end) refuse("cannot read {}: the file ends too early; write the file again", what);
  Image image{.width = static_cast<uint32_t>(width), .height = static_cast<uint32_t>(height), .planes = {}};
  const size_t pixels = size_t{image.width} * image.height;
  static constexpr const char* names[] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) {
    Plane plane{.name = names[c], .type = Plane::Type::single, .values = std::vector<float>(pixels), .uint_values = {}};
    for (size_t i = 0; i < pixels; ++i) plane.values[i] = texels.get()[3 * i + c];
    image.planes.push_back(std::move(plane));
  }
  return image;
}

}  // namespace sideray::scenes
