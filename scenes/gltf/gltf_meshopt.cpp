#include <meshoptimizer.h>

#include <cmath>

#include "scenes/gltf/gltf.h"

// Decodes EXT_meshopt_compression; only this file knows meshoptimizer. Its decoders are safe for untrusted bytes, but
// check their arguments by assertions only.
namespace sideray::scenes::gltf {
namespace {

constexpr const char* meshopt_extension = "EXT_meshopt_compression";

struct Stream {
  std::span<const uint8_t> bytes;
  size_t count = 0, stride = 0;
  std::string mode, filter;
};

size_t whole(const File& file, const tinygltf::Value& e, const char* key, const std::string& user) {
  const double value = number(file, e, key, 0.0);
  if (!(value >= 1.0 && value <= 2147483647.0) || value != std::floor(value)) {
    refuse("cannot read {}: {} of {} is not a whole number from 1 to 2^31-1; export it again", file.path, key, user);
  }
  return static_cast<size_t>(value);
}

std::string word(const tinygltf::Value& e, const char* key, const char* fallback) {
  return e.Has(key) && e.Get(key).IsString() ? e.Get(key).Get<std::string>() : fallback;
}

// Returns whether the extension allows these sizes for the mode and the filter.
bool allowed(const Stream& s) {
  if (s.mode == "ATTRIBUTES" && (s.stride % 4 != 0 || s.stride > 256)) return false;
  if (s.mode == "TRIANGLES" && s.count % 3 != 0) return false;
  if (s.mode == "TRIANGLES" || s.mode == "INDICES") return (s.stride == 2 || s.stride == 4) && s.filter == "NONE";
  if (s.filter == "OCTAHEDRAL") return s.mode == "ATTRIBUTES" && (s.stride == 4 || s.stride == 8);
  if (s.filter == "QUATERNION") return s.mode == "ATTRIBUTES" && s.stride == 8;
  return s.mode == "ATTRIBUTES" && (s.filter == "NONE" || s.filter == "EXPONENTIAL");
}

// Returns whether so few bytes can hold the elements: 16 equal bytes of an attribute still take 2 bits, and every
// triangle or index a byte.
bool plausible(const Stream& s) {
  return s.count * s.stride <= 64 * s.bytes.size();
}

bool decode(const Stream& s, std::vector<uint8_t>& to) {
  int result = -1;
  if (s.mode == "ATTRIBUTES")
    result = meshopt_decodeVertexBuffer(to.data(), s.count, s.stride, s.bytes.data(), s.bytes.size());
  else if (s.mode == "TRIANGLES")
    result = meshopt_decodeIndexBuffer(to.data(), s.count, s.stride, s.bytes.data(), s.bytes.size());
  else
    result = meshopt_decodeIndexSequence(to.data(), s.count, s.stride, s.bytes.data(), s.bytes.size());
  if (result != 0) return false;
  if (s.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to.data(), s.count, s.stride);
  if (s.filter == "QUATERNION") meshopt_decodeFilterQuat(to.data(), s.count, s.stride);
  if (s.filter == "EXPONENTIAL") meshopt_decodeFilterExp(to.data(), s.count, s.stride);
  return true;
}

}  // namespace

void decode_meshopt(File& file) {
  for (size_t i = 0; i < file.model.bufferViews.size(); ++i) {
    tinygltf::BufferView& view = file.model.bufferViews[i];
    const tinygltf::Value* e = extension(view.extensions, meshopt_extension);
    if (e == nullptr) continue;
    const std::string user = fmt::format("bufferView {}", i);
    const std::vector<unsigned char>& data = file.model.buffers[static_cast<size_t>(view.buffer)].data;
    const Stream stream{.bytes = std::span(data).subspan(view.byteOffset, view.byteLength),
                        .count = whole(file, *e, "count", user),
                        .stride = whole(file, *e, "byteStride", user),
                        .mode = word(*e, "mode", "without name"),
                        .filter = word(*e, "filter", "NONE")};
    if (!allowed(stream)) {
      refuse("cannot read {}: {} is compressed in the mode {}, filter {}, {} times {} bytes, which {} lacks; {}",
             file.path, user, stream.mode, stream.filter, stream.count, stream.stride, meshopt_extension, "export it again");
    }
    std::vector<uint8_t> decoded;
    if (plausible(stream)) {
      file.budget.take(stream.count * stream.stride, user);
      file.budget.check_time(user);
      decoded.resize(stream.count * stream.stride);
    }
    if (decoded.empty() || !decode(stream, decoded)) {
      refuse("cannot read {}: the meshopt data of {} is damaged; get the file again", file.path, user);
    }
    const int added = add_buffer(file, std::move(decoded));
    view.buffer = added;
    view.byteOffset = 0;
    view.byteLength = stream.count * stream.stride;
  }
}

}  // namespace sideray::scenes::gltf
