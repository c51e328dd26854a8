#include "scenes/images/images.h"

#include <algorithm>
#include <cmath>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"
#include "scenes/images/image_codecs.h"

namespace sideray::scenes {
namespace {

Image image_from_png(const PngPixels& png) {
  static constexpr const char* names[] = {"R", "G", "B", "A"};
  Image image{.width = png.width, .height = png.height, .planes = {}, .linear = false};
  const size_t pixels = size_t{png.width} * png.height;
  for (uint32_t c = 0; c < png.channels; ++c) {
    Plane plane{.name = names[c], .type = Plane::Type::single, .values = std::vector<float>(pixels), .uint_values = {}};
    for (size_t i = 0; i < pixels; ++i) {
      const size_t sample = i * png.channels + c;
      if (png.bits == 16) {
        // Samples are in native byte order.
        const uint8_t* bytes = png.samples.data() + 2 * sample;
        plane.values[i] = static_cast<float>(bytes[0] | bytes[1] << 8) / 65535.0f;
      } else {
        plane.values[i] = static_cast<float>(png.samples[sample]) / 255.0f;
      }
    }
    image.planes.push_back(std::move(plane));
  }
  return image;
}

}  // namespace

void check_image_size(uint64_t width, uint64_t height, const std::string& what) {
  if (width == 0 || height == 0) refuse("cannot read {}: it says it has no pixels; write the file again", what);
  if (width > limits::picture_side || height > limits::picture_side) {
    refuse("cannot read {}: {} x {} pixels are more than {} a side; use a smaller picture", what, width, height,
           limits::picture_side);
  }
}

void check_image_values(uint64_t channels, uint64_t width, uint64_t height, const std::string& what) {
  if (channels * width * height > limits::picture_values)
    refuse("cannot read {}: {} channels of {} x {} pixels are too much; use a smaller picture", what, channels, width,
           height);
}

void take_texels(Budget* budget, uint64_t width, uint64_t height, uint64_t work_bytes, const std::string& what) {
  if (budget == nullptr) return;
  budget->check_time(what);
  budget->take(4 * width * height, what);
  budget->check_memory(work_bytes * width * height, what);
}

const Plane* Image::find(const std::string& name) const {
  const auto found = std::find_if(planes.begin(), planes.end(), [&](const Plane& p) { return p.name == name; });
  return found == planes.end() ? nullptr : &*found;
}

Image read_image(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension == ".png") return image_from_png(decode_png(read_file(path, limits::picture_file_bytes), path));
  if (extension == ".exr") return read_exr(path);
  if (extension == ".hdr") return decode_hdr(read_file(path, limits::picture_file_bytes), path);
  refuse("cannot read {}: unknown picture format \"{}\"; use .png, .exr or .hdr", path, extension);
}

void write_png(const std::string& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb) {
  write_file(path, encode_png(width, height, 3, rgb, path));
}

Decoded decode_image(std::span<const uint8_t> bytes, const std::string& what, Budget* budget) {
  if (bytes.empty()) refuse("cannot read {}: it has no bytes; get it again", what);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, what, budget);
  if (is_webp(bytes)) return decode_webp(bytes, what, budget);
  if (!is_png(bytes)) refuse("cannot read {}: it is neither PNG, JPEG nor WebP; convert it to one of them", what);
  return decode_png_texels(bytes, what, budget);
}

}  // namespace sideray::scenes
