#include <algorithm>
#include <sideray/sideray.hpp>

#include "fuzz/fuzz.h"
#include "fuzz/memory_file.h"
#include "scenes/images/images.h"

// The picture decoders: the formats of a scene's textures from memory, those of whole picture files by extension.
namespace {

using namespace sideray;

tests::MemoryFile* file_for(std::span<const uint8_t> bytes) {
  static tests::MemoryFile exr(".exr"), hdr(".hdr"), png(".png");
  if (bytes.empty()) return nullptr;
  if (bytes[0] == 0x76) return &exr;
  if (bytes[0] == '#') return &hdr;
  return bytes[0] == 0x89 ? &png : nullptr;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> bytes(data, size);
  try {
    if (tests::MemoryFile* file = file_for(bytes)) {
      file->put(bytes);
      const scenes::Image image = scenes::read_image(file->path());
      for (const scenes::Plane& plane : image.planes)
        if (std::max(plane.values.size(), plane.uint_values.size()) != size_t{image.width} * image.height)
          fuzz::broken("a plane has a value for each pixel", plane.name);
    }
  } catch (const Error& error) {
    fuzz::check_message(error.what());
  }
  try {
    const scenes::Decoded decoded = scenes::decode_image(bytes, "picture");
    if (decoded.rgba.size() != size_t{4} * decoded.width * decoded.height)
      fuzz::broken("a picture has four bytes for each pixel", std::to_string(decoded.rgba.size()));
  } catch (const Error& error) {
    fuzz::check_message(error.what());
  }
  return 0;
}
