#include <webp/decode.h>

#include <algorithm>

#include "scenes/base/files.h"
#include "scenes/images/image_codecs.h"

namespace sideray::scenes {

bool is_webp(std::span<const uint8_t> bytes) {
  static constexpr uint8_t riff[] = {'R', 'I', 'F', 'F'}, webp[] = {'W', 'E', 'B', 'P'};
  return bytes.size() >= 12 && std::equal(riff, riff + 4, bytes.begin()) &&
         std::equal(webp, webp + 4, bytes.begin() + 8);
}

Decoded decode_webp(std::span<const uint8_t> bytes, const std::string& what, Budget* budget) {
  WebPBitstreamFeatures features;
  const VP8StatusCode status = WebPGetFeatures(bytes.data(), bytes.size(), &features);
  if (status == VP8_STATUS_NOT_ENOUGH_DATA) {
    refuse("cannot read {}: the file ends too early; write the file again", what);
  }
  if (status != VP8_STATUS_OK) refuse("cannot read {}: its WebP header is damaged; write the file again", what);
  if (features.has_animation != 0) refuse("cannot read {}: it is an animation; use a still picture", what);
  check_image_size(static_cast<uint64_t>(features.width), static_cast<uint64_t>(features.height), what);
  // The lossless decoder holds a second copy of all pixels.
  take_texels(budget, static_cast<uint64_t>(features.width), static_cast<uint64_t>(features.height), 4, what);
  Decoded decoded{static_cast<uint32_t>(features.width), static_cast<uint32_t>(features.height), {}};
  decoded.rgba.resize(size_t{4} * decoded.width * decoded.height);
  // Where the picture has no alpha, the decoder sets it to 255.
  if (WebPDecodeRGBAInto(bytes.data(), bytes.size(), decoded.rgba.data(), decoded.rgba.size(), 4 * features.width) ==
      nullptr) {
    refuse("cannot read {}: its data is damaged or ends too early; write the file again", what);
  }
  return decoded;
}

}  // namespace sideray::scenes
