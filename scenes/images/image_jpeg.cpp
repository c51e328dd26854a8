#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "scenes/base/files.h"
#include "scenes/images/image_codecs.h"

namespace sideray::scenes {
namespace {

struct DestroyCodec {
  void operator()(void* codec) const { tjDestroy(codec); }
};
using Codec = std::unique_ptr<void, DestroyCodec>;

[[noreturn]] void refuse_decoding(tjhandle decoder, const std::string& what) {
  refuse("cannot read {}: {}; write the file again", what, tjGetErrorStr2(decoder));
}

// As written by Adobe: 255 is no ink.
void convert_cmyk(std::vector<uint8_t>& pixels) {
  for (size_t i = 0; i < pixels.size(); i += 4) {
    const uint32_t key = pixels[i + 3];
    for (size_t c = 0; c < 3; ++c) pixels[i + c] = static_cast<uint8_t>((pixels[i + c] * key + 127) / 255);
    pixels[i + 3] = 255;
  }
}

}  // namespace

bool is_jpeg(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what) {
  // A decoder fills what is missing with grey; a JPEG that was cut lacks its end marker.
  static constexpr uint8_t end_of_image[] = {0xff, 0xd9};
  if (std::search(bytes.rbegin(), bytes.rend(), std::rbegin(end_of_image), std::rend(end_of_image)) == bytes.rend()) {
    refuse("cannot read {}: the file ends too early; write the file again", what);
  }
  const Codec decoder(tjInitDecompress());
  if (!decoder) refuse("cannot read {}: no memory for decoding it; use a smaller picture", what);
  int width = 0, height = 0, subsampling = 0, colours = 0;
  const auto size = static_cast<unsigned long>(bytes.size());
  if (tjDecompressHeader3(decoder.get(), bytes.data(), size, &width, &height, &subsampling, &colours) != 0) {
    refuse_decoding(decoder.get(), what);
  }
  check_image_size(static_cast<uint64_t>(width), static_cast<uint64_t>(height), what);
  const bool is_cmyk = colours == TJCS_CMYK || colours == TJCS_YCCK;
  Decoded decoded{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
  decoded.rgba.resize(size_t{4} * decoded.width * decoded.height);
  // A few kilobytes of progressive scans can ask for hours: their number is limited.
  const int status = tjDecompress2(decoder.get(), bytes.data(), size, decoded.rgba.data(), width, 0, height,
                                   is_cmyk ? TJPF_CMYK : TJPF_RGBA, TJFLAG_LIMITSCANS);
  // Warnings are of pictures that every viewer shows, such as bytes between segments.
  if (status != 0 && tjGetErrorCode(decoder.get()) != TJERR_WARNING) refuse_decoding(decoder.get(), what);
  if (is_cmyk) convert_cmyk(decoded.rgba);
  return decoded;
}

std::vector<uint8_t> encode_jpeg(uint32_t width, uint32_t height, std::span<const uint8_t> rgb, int quality,
                                 const std::string& what) {
  if (width == 0 || height == 0 || rgb.size() != size_t{3} * width * height)
    refuse("cannot write {}: {} bytes are not a picture of {} x {} x 3; pass width * height * 3 bytes", what,
           rgb.size(), width, height);
  const Codec encoder(tjInitCompress());
  if (!encoder) refuse("cannot write {}: no memory for encoding it; use a smaller picture", what);
  const int columns = static_cast<int>(width), lines = static_cast<int>(height);
  std::vector<uint8_t> bytes(tjBufSize(columns, lines, TJSAMP_420));
  uint8_t* out = bytes.data();
  auto size = static_cast<unsigned long>(bytes.size());
  if (tjCompress2(encoder.get(), rgb.data(), columns, 0, lines, TJPF_RGB, &out, &size, TJSAMP_420, quality,
                  TJFLAG_NOREALLOC) != 0)
    refuse("cannot write {}: {}; make the picture smaller", what, tjGetErrorStr2(encoder.get()));
  bytes.resize(size);
  return bytes;
}

}  // namespace sideray::scenes
