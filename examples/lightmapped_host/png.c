/* Writes PNG without compression: one zlib stream of stored blocks. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"

enum { most_stored = 65535 };

static void put_big_endian(uint8_t* to, uint32_t value) {
  for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(value >> (24 - 8 * i));
}

static uint32_t crc_of(const uint8_t* bytes, size_t count) {
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u);
  }
  return ~crc;
}

static void write_chunk(FILE* file, const char* name, const uint8_t* content, size_t count) {
  uint8_t* chunk = malloc(count + 12);
  require(chunk != NULL, "no memory for a picture");
  put_big_endian(chunk, (uint32_t)count);
  memcpy(chunk + 4, name, 4);
  memcpy(chunk + 8, content, count);
  put_big_endian(chunk + 8 + count, crc_of(chunk + 4, count + 4));
  fwrite(chunk, 1, count + 12, file);
  free(chunk);
}

/* Returns `raw` as a zlib stream; the caller frees it. */
static uint8_t* stored(const uint8_t* raw, size_t count, size_t* bytes) {
  uint8_t *stream = malloc(count + 6 + 5 * (count / most_stored + 1)), *to = stream;
  require(stream != NULL, "no memory for a picture");
  *to++ = 0x78, *to++ = 0x01;
  for (size_t first = 0; first < count; first += most_stored) {
    const size_t size = count - first < most_stored ? count - first : most_stored;
    *to++ = first + size == count;
    *to++ = (uint8_t)size, *to++ = (uint8_t)(size >> 8);
    *to++ = (uint8_t)~size, *to++ = (uint8_t)(~size >> 8);
    memcpy(to, raw + first, size);
    to += size;
  }
  uint32_t a = 1, b = 0; /* Adler-32 */
  for (size_t i = 0; i < count; ++i) a = (a + raw[i]) % 65521u, b = (b + a) % 65521u;
  put_big_endian(to, b << 16 | a);
  *bytes = (size_t)(to + 4 - stream);
  return stream;
}

void write_png(const char* path, const uint8_t* rgb, int width, int height) {
  static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const size_t row = 3 * (size_t)width, raw_bytes = (row + 1) * (size_t)height;
  uint8_t header[13] = {0}, *raw = malloc(raw_bytes);
  FILE* file = fopen(path, "wb");
  require(raw && file, path);
  put_big_endian(header, (uint32_t)width), put_big_endian(header + 4, (uint32_t)height);
  header[8] = 8, header[9] = 2;
  for (int y = 0; y < height; ++y) {
    raw[(row + 1) * (size_t)y] = 0; /* no filter */
    memcpy(raw + (row + 1) * (size_t)y + 1, rgb + row * (size_t)(height - 1 - y), row);
  }
  size_t bytes = 0;
  uint8_t* stream = stored(raw, raw_bytes, &bytes);
  fwrite(signature, 1, sizeof(signature), file);
  write_chunk(file, "IHDR", header, sizeof(header));
  write_chunk(file, "IDAT", stream, bytes);
  write_chunk(file, "IEND", header, 0);
  require(!ferror(file) && fclose(file) == 0, path);
  free(stream);
  free(raw);
}
