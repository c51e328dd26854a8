#include "scenes/gltf/file/container.h"

#include <cstring>

#include "scenes/base/files.h"

namespace sideray::scenes::gltf {
namespace {

constexpr uint32_t json_chunk = 0x4e4f534a;

uint32_t read_u32(std::span<const uint8_t> bytes, size_t offset) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

}  // namespace

bool is_binary(std::span<const uint8_t> bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

std::span<const uint8_t> json_text(std::span<const uint8_t> bytes, const std::string& path) {
  if (!is_binary(bytes)) return bytes;
  if (bytes.size() < 20) refuse("cannot read {}: the file ends inside its header; get it again", path);
  const uint32_t version = read_u32(bytes, 4), length = read_u32(bytes, 8), json_length = read_u32(bytes, 12);
  if (version != 2) refuse("cannot read {}: glTF {} is not read; convert it to glTF 2.0", path, version);
  if (length > bytes.size()) {
    refuse("cannot read {}: it should have {} bytes and has {}; get it again", path, length, bytes.size());
  }
  if (length < 20 || json_length > length - 20) {
    refuse("cannot read {}: its JSON of {} bytes ends outside its {} bytes; get it again", path, json_length, length);
  }
  if (read_u32(bytes, 16) != json_chunk) refuse("cannot read {}: its first chunk is not JSON; export it again", path);
  return bytes.subspan(20, json_length);
}

void drop_empty_chunk(std::vector<uint8_t>& bytes) {
  if (!is_binary(bytes) || bytes.size() < 20) return;
  const size_t end = size_t{20} + read_u32(bytes, 12);
  if (bytes.size() < end + 8 || read_u32(bytes, 8) != end + 8 || read_u32(bytes, end) != 0) return;
  bytes.resize(end);
  const auto length = static_cast<uint32_t>(end);
  std::memcpy(&bytes[8], &length, 4);
}

std::vector<uint8_t> with_json(std::span<const uint8_t> bytes, std::string json) {
  if (!is_binary(bytes)) return {json.begin(), json.end()};
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto rest = bytes.subspan(20 + read_u32(bytes, 12), read_u32(bytes, 8) - 20 - read_u32(bytes, 12));
  std::vector<uint8_t> result(bytes.begin(), bytes.begin() + 20);
  const uint32_t json_length = static_cast<uint32_t>(json.size());
  const uint32_t length = static_cast<uint32_t>(20 + json.size() + rest.size());
  std::memcpy(&result[8], &length, 4);
  std::memcpy(&result[12], &json_length, 4);
  result.insert(result.end(), json.begin(), json.end());
  result.insert(result.end(), rest.begin(), rest.end());
  return result;
}

}  // namespace sideray::scenes::gltf
