#include "bridge/transport/texture_upload.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace sideray::bridge {
namespace {

constexpr uint64_t longest_wait_ns = 100'000'000;
constexpr uint64_t bytes_of_part = 1 << 17;  // copied by one thread at a time

uint64_t bytes_of(const TexturePiece& p) {
  return uint64_t{p.where.width} * p.where.height * p.format.bytes;
}

// Returns the bytes of a piece in a buffer, rounded up to 4, since each must begin at a multiple of its type's size.
uint64_t room_of(const TexturePiece& p) {
  return (bytes_of(p) + 3) / 4 * 4;
}

// Copies rows, tightly packed as the texture wants them.
void copy_rows(const TexturePiece& p, uint32_t first_row, uint32_t rows, std::byte* to) {
  for (uint32_t row = first_row; row < first_row + rows; ++row, to += size_t{p.where.width} * p.format.bytes) {
    const size_t first = size_t{p.where.y + row} * p.row_texels + p.where.x;
    std::memcpy(to, p.layer_texels + first * p.format.bytes, size_t{p.where.width} * p.format.bytes);
  }
}

// Copies all pieces one after another into the buffer, in parallel: one core alone is slower than the GPU's transfer.
void copy_in_parallel(std::span<const TexturePiece> pieces, std::byte* to, rt::Executor& copiers) {
  struct Part {
    const TexturePiece* piece;
    uint32_t first_row, rows;
    std::byte* to;
  };
  std::vector<Part> parts;
  for (const TexturePiece& p : pieces) {
    const uint64_t row_bytes = uint64_t{p.where.width} * p.format.bytes;
    const auto rows = static_cast<uint32_t>(std::max<uint64_t>(bytes_of_part / std::max<uint64_t>(row_bytes, 1), 1));
    for (uint32_t row = 0; row < p.where.height; row += rows)
      parts.push_back({&p, row, std::min(rows, p.where.height - row), to + row * row_bytes});
    to += room_of(p);
  }
  copiers.run(parts.size(), [&](size_t i, uint32_t) {
    copy_rows(*parts[i].piece, parts[i].first_row, parts[i].rows, parts[i].to);
  });
}

// Does the same without allocations where memory for tasks is lacking: an upload that has begun must not fail.
void copy_all(std::span<const TexturePiece> pieces, std::byte* to, rt::Executor& copiers) try {
  copy_in_parallel(pieces, to, copiers);
} catch (const std::bad_alloc&) {
  for (const TexturePiece& p : pieces) {
    copy_rows(p, 0, p.where.height, to);
    to += room_of(p);
  }
}

void set_texels(const gl::Functions& gl, const TexturePiece& p, uint32_t row_texels, const void* texels) {
  const auto x = static_cast<GLint>(p.where.x), y = static_cast<GLint>(p.where.y);
  const auto width = static_cast<GLsizei>(p.where.width), height = static_cast<GLsizei>(p.where.height);
  gl.PixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(row_texels));
  if (p.target == GL_TEXTURE_2D)
    gl.TexSubImage2D(p.target, 0, x, y, width, height, p.format.format, p.format.type, texels);
  else
    gl.TexSubImage3D(p.target, 0, x, y, static_cast<GLint>(p.layer), width, height, 1, p.format.format, p.format.type,
                     texels);
}

}  // namespace

// Returns a buffer that the driver is not reading, or null where there is no memory for one. Makes a second one if
// uploads follow each other faster than the driver reads them.
TextureUpload::Staging* TextureUpload::require_staging(const gl::Functions& gl, uint64_t bytes) {
  const auto is_free = [](const Staging& s) { return !s.read || s.read.wait_or_give_up(0); };
  auto chosen = std::find_if(stagings_.begin(), stagings_.end(), is_free);
  if (chosen == stagings_.end()) {
    chosen = stagings_.begin();
    // Makes a new buffer instead of waiting forever: the driver keeps the old one until it has read it.
    if (!chosen->read.wait_or_give_up(longest_wait_ns)) chosen->capacity = 0;
    std::rotate(stagings_.begin(), chosen + 1, stagings_.end());  // keeps the order in which they were sent
    chosen = stagings_.end() - 1;
  }
  Staging& s = *chosen;
  s.read.reset();
  if (s.capacity >= bytes) return &s;
  constexpr GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  s.capacity = 0;
  s.mapped = nullptr;
  s.buffer.reset();
  GLuint name = 0;
  gl.GenBuffers(1, &name);
  if (name == 0) return nullptr;
  s.buffer = gl::Buffer(gl, name);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, name);
  gl.BufferStorage(GL_PIXEL_UNPACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, flags);
  if (gl.GetError() == GL_NO_ERROR)
    s.mapped =
        static_cast<std::byte*>(gl.MapBufferRange(GL_PIXEL_UNPACK_BUFFER, 0, static_cast<GLsizeiptr>(bytes), flags));
  s.capacity = s.mapped ? bytes : 0;
  while (!s.mapped && gl.GetError() == GL_OUT_OF_MEMORY) {
  }
  return s.mapped ? &s : nullptr;
}

uint64_t TextureUpload::send(const gl::Functions& gl, std::span<const TexturePiece> pieces, const UploadWay& way) {
  uint64_t bytes = 0, room = 0;
  for (const TexturePiece& p : pieces) {
    bytes += bytes_of(p);
    room += room_of(p);
  }
  if (bytes == 0) return 0;
  Staging* staging = way.persistent ? require_staging(gl, room) : nullptr;
  if (staging) copy_all(pieces, staging->mapped, way.copiers);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, staging ? staging->buffer.id() : 0);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  uint64_t at = 0;
  for (const TexturePiece& p : pieces) {
    gl.BindTexture(p.target, p.texture);
    if (staging) {
      set_texels(gl, p, 0, reinterpret_cast<const void*>(at));
    } else {
      const size_t first = size_t{p.where.y} * p.row_texels + p.where.x;
      set_texels(gl, p, p.row_texels, p.layer_texels + first * p.format.bytes);
    }
    at += room_of(p);
  }
  if (staging) staging->read = gl::Fence::try_issue(gl);
  if (staging && !staging->read) gl.Finish();
  return bytes;
}

void TextureUpload::abandon() {
  for (Staging& s : stagings_) {
    s.buffer.abandon();
    s.read.abandon();
    s.mapped = nullptr;
    s.capacity = 0;
  }
}

}  // namespace sideray::bridge
