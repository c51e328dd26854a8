#include "gl/passes/layer_truth.h"

#include <algorithm>

#include "model/failure.h"

namespace sideray::gl {
namespace {

// Uploads elements of `stride` unsigned integers.
Texture upload_list(const Functions& gl, const uint32_t* elements, size_t count, int stride) {
  constexpr size_t width = LayerTruthTextures::width;
  const size_t rows = std::max<size_t>((count + width - 1) / width, 1);
  GLint most = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (rows > static_cast<size_t>(most))
    fail(SIDERAY_UNSUPPORTED, "check: {} true layers are more than the driver's textures hold ({}x{}); lower the size",
         count, width, most);
  Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  const GLenum format = stride == 1 ? GL_RED_INTEGER : GL_RG_INTEGER;
  gl.TexImage2D(GL_TEXTURE_2D, 0, stride == 1 ? GL_R32UI : GL_RG32UI, LayerTruthTextures::width,
                static_cast<GLsizei>(rows), 0, format, GL_UNSIGNED_INT, nullptr);
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "check: the driver has no room for {} true layers; lower the size", count);
  const size_t whole = count / width, rest = count % width;
  const auto write = [&](size_t row, size_t columns, size_t height) {
    if (columns == 0 || height == 0) return;
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, static_cast<GLint>(row), static_cast<GLsizei>(columns),
                     static_cast<GLsizei>(height), format, GL_UNSIGNED_INT,
                     elements + row * width * static_cast<size_t>(stride));
  };
  write(0, width, whole);
  write(whole, rest, 1);
  return texture;
}

}  // namespace

LayerTruthTextures::LayerTruthTextures(const Functions& gl, const LayerTruth& truth)
    : first(upload_list(gl, truth.first.data(), truth.first.size(), 1)),
      surfaces(upload_list(gl, truth.surfaces.empty() ? nullptr : &truth.surfaces[0].x, truth.surfaces.size(), 2)) {}

}  // namespace sideray::gl
