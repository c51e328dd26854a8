#include "preload/base/png.h"

#include <algorithm>
#include <array>

namespace sideray::run {
namespace {

void append_32(std::string& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255u);
}

uint32_t crc(const std::string& bytes) {
  uint32_t sum = ~0u;
  for (const char byte : bytes) {
    sum ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0u);
  }
  return ~sum;
}

void append_chunk(std::string& file, const std::string& name, const std::string& body) {
  append_32(file, static_cast<uint32_t>(body.size()));
  file += name + body;
  append_32(file, crc(name + body));
}

uint32_t adler(const std::string& bytes) {
  uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<unsigned char>(byte)) % 65521;
    b = (b + a) % 65521;
  }
  return b << 16 | a;
}

// Returns a zlib stream of stored blocks, without compression.
std::string stored(const std::string& bytes) {
  constexpr size_t largest = 65535;
  std::string stream = "\x78\x01";
  for (size_t at = 0; at < bytes.size() || at == 0; at += largest) {
    const size_t size = std::min(largest, bytes.size() - at);
    stream += static_cast<char>(at + size >= bytes.size());
    for (const size_t word : {size, ~size}) {
      stream += static_cast<char>(word & 255);
      stream += static_cast<char>(word >> 8 & 255);
    }
    stream.append(bytes, at, size);
  }
  append_32(stream, adler(bytes));
  return stream;
}

}  // namespace

std::string png(int width, int height, int channels, const std::vector<uint8_t>& texels) {
  std::string header, rows;
  append_32(header, static_cast<uint32_t>(width));
  append_32(header, static_cast<uint32_t>(height));
  header += {8, static_cast<char>(channels == 4 ? 6 : 2), 0, 0, 0};
  const size_t stride = static_cast<size_t>(width) * static_cast<size_t>(channels);
  for (size_t y = 0; y < static_cast<size_t>(height); ++y) {
    rows += '\0';
    rows.append(reinterpret_cast<const char*>(texels.data()) + y * stride, stride);
  }
  std::string file = "\x89PNG\r\n\x1a\n";
  append_chunk(file, "IHDR", header);
  append_chunk(file, "IDAT", stored(rows));
  append_chunk(file, "IEND", "");
  return file;
}

std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t at = 0; at < bytes.size(); at += 3) {
    std::array<uint32_t, 3> three{};
    const size_t count = std::min<size_t>(3, bytes.size() - at);
    for (size_t i = 0; i < count; ++i) three[i] = static_cast<unsigned char>(bytes[at + i]);
    const uint32_t word = three[0] << 16 | three[1] << 8 | three[2];
    for (size_t i = 0; i < 4; ++i) text += i <= count ? digits[word >> (18 - 6 * i) & 63] : '=';
  }
  return text;
}

}  // namespace sideray::run
