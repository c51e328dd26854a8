#include "bridge/transport/texture_upload.h"

#include <cstring>

#include "bridge/transport/rgb9e5.h"

namespace sideray::bridge {
namespace {

constexpr uint64_t longest_wait_ns = 100'000'000;

uint64_t bytes_of(const TexturePiece& p) {
  return uint64_t{p.where.width} * p.where.height * p.format.bytes;
}

// A piece in a buffer has to begin at a multiple of its type's size, of which 4 is the largest.
uint64_t room_of(const TexturePiece& p) {
  return (bytes_of(p) + 3) / 4 * 4;
}

// Tightly packed rows, as the texture wants them.
void copy_rows(const TexturePiece& p, std::byte* to) {
  for (uint32_t row = 0; row < p.where.height; ++row, to += size_t{p.where.width} * p.format.bytes) {
    const size_t first = size_t{p.where.y + row} * p.row_texels + p.where.x;
    const std::byte* from = p.layer_texels + first * p.format.source_bytes;
    if (p.format.bytes == p.format.source_bytes)
      std::memcpy(to, from, size_t{p.where.width} * p.format.bytes);
    else
      pack_rgb9e5(reinterpret_cast<const uint16_t*>(from), reinterpret_cast<uint32_t*>(to), p.where.width);
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

// False: there is no memory for it.
bool TextureUpload::require_mapped(const gl::Functions& gl, uint64_t bytes) {
  // Rather a new buffer than to wait for ever: the driver keeps the old one until it has read it.
  if (read_ && !read_.wait_or_give_up(longest_wait_ns)) capacity_ = 0;
  read_.reset();
  if (capacity_ >= bytes) return true;
  constexpr GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  capacity_ = 0;
  mapped_ = nullptr;
  buffer_.reset();
  GLuint name = 0;
  gl.GenBuffers(1, &name);
  if (name == 0) return false;
  buffer_ = gl::Buffer(gl, name);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, name);
  gl.BufferStorage(GL_PIXEL_UNPACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, flags);
  if (gl.GetError() == GL_NO_ERROR)
    mapped_ =
        static_cast<std::byte*>(gl.MapBufferRange(GL_PIXEL_UNPACK_BUFFER, 0, static_cast<GLsizeiptr>(bytes), flags));
  capacity_ = mapped_ ? bytes : 0;
  while (!mapped_ && gl.GetError() == GL_OUT_OF_MEMORY) {
  }
  return mapped_ != nullptr;
}

uint64_t TextureUpload::send(const gl::Functions& gl, std::span<const TexturePiece> pieces, bool persistent) {
  uint64_t bytes = 0, room = 0;
  for (const TexturePiece& p : pieces) bytes += bytes_of(p), room += room_of(p);
  if (bytes == 0) return 0;
  persistent = persistent && require_mapped(gl, room);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, persistent ? buffer_.id() : 0);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  uint64_t at = 0;
  for (const TexturePiece& p : pieces) {
    gl.BindTexture(p.target, p.texture);
    if (persistent) {
      copy_rows(p, mapped_ + at);
      set_texels(gl, p, 0, reinterpret_cast<const void*>(at));
    } else if (p.format.bytes != p.format.source_bytes) {
      packed_.resize(bytes_of(p) / sizeof(uint32_t));
      copy_rows(p, reinterpret_cast<std::byte*>(packed_.data()));
      set_texels(gl, p, 0, packed_.data());
    } else {
      const size_t first = size_t{p.where.y} * p.row_texels + p.where.x;
      set_texels(gl, p, p.row_texels, p.layer_texels + first * p.format.source_bytes);
    }
    at += room_of(p);
  }
  if (persistent) read_ = gl::Fence::try_issue(gl);
  if (persistent && !read_) gl.Finish();
  return bytes;
}

void TextureUpload::abandon() {
  buffer_.abandon();
  read_.abandon();
  mapped_ = nullptr;
  capacity_ = 0;
}

}  // namespace sideray::bridge
