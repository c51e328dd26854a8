#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"
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

// Converts CMYK as Adobe writes it, inverted: 255 is no ink.
void convert_cmyk(std::vector<uint8_t>& pixels) {
  for (size_t i = 0; i < pixels.size(); i += 4) {
    const uint32_t key = pixels[i + 3];
    for (size_t c = 0; c < 3; ++c) pixels[i + c] = static_cast<uint8_t>((pixels[i + c] * key + 127) / 255);
    pixels[i + 3] = 255;
  }
}

// Counts the scans, each of which takes a pass over the picture: a few kilobytes of them can take hours.
uint64_t scans_of(std::span<const uint8_t> bytes) {
  constexpr uint8_t start_of_scan = 0xda;
  uint64_t scans = 0;
  for (size_t i = 0; i + 1 < bytes.size(); ++i) scans += bytes[i] == 0xff && bytes[i + 1] == start_of_scan;
  return scans;
}

// Returns the bytes of all coefficients of a texel.
uint64_t coefficient_bytes(int subsampling) {
  switch (subsampling) {
    case TJSAMP_GRAY:
      return 2;
    case TJSAMP_420:
    case TJSAMP_411:
      return 3;
    case TJSAMP_422:
    case TJSAMP_440:
      return 4;
    default:
      return 8;
  }
}

}  // namespace

bool is_jpeg(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

Decoded decode_jpeg(std::span<const uint8_t> bytes, const std::string& what, Budget* budget) {
  // A truncated JPEG lacks its end marker. The decoder would fill the missing part with grey.
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
  const uint64_t texels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height), scans = scans_of(bytes);
  if (scans * texels > limits::jpeg_scan_texels)
    refuse("cannot read {}: its {} scans go over {} x {} pixels too often; write it again as a baseline JPEG", what,
           scans, width, height);
  // With several scans the decoder keeps the coefficients of the whole picture: two bytes for each of up to four
  // colours.
  take_texels(budget, static_cast<uint64_t>(width), static_cast<uint64_t>(height),
              scans > 1 ? coefficient_bytes(subsampling) : 0, what);
  const bool is_cmyk = colours == TJCS_CMYK || colours == TJCS_YCCK;
  Decoded decoded{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
  decoded.rgba.resize(size_t{4} * decoded.width * decoded.height);
  const int status = tjDecompress2(decoder.get(), bytes.data(), size, decoded.rgba.data(), width, 0, height,
                                   is_cmyk ? TJPF_CMYK : TJPF_RGBA, 0);
  // Every viewer shows pictures that cause only warnings, such as for bytes between segments.
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
