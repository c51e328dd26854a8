// Hashes memory, for names of textures and meshes that stay the same in every run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace sideray::run {

inline uint64_t mix(uint64_t hash, uint64_t word) {
  hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
  return hash ^ (hash >> 29);
}

inline uint64_t hash_bytes(const void* data, size_t size, uint64_t hash = 0x2545f4914f6cdd1du) {
  const char* bytes = static_cast<const char*>(data);
  for (; size >= 8; bytes += 8, size -= 8) {
    uint64_t word;
    std::memcpy(&word, bytes, 8);
    hash = mix(hash, word);
  }
  uint64_t rest = size;
  for (size_t i = 0; i < size; ++i) rest = rest << 8 | static_cast<unsigned char>(bytes[i]);
  return mix(hash, rest);
}

// Returns sixteen hexadecimal digits, as in rules files and reports.
std::string hash_text(uint64_t hash);

}  // namespace sideray::run
