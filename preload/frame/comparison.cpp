#include "preload/frame/comparison.h"

#include <fstream>

#include "preload/base/png.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

void put_pixels_alone() {
  const Functions& gl = real();
  gl.UseProgram(0);
  for (const GLenum off : {GL_LIGHTING, GL_FOG, GL_BLEND, GL_ALPHA_TEST, GL_STENCIL_TEST, GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_COLOR_LOGIC_OP}) gl.Disable(off);
  for (int unit = 0; unit < texture_units(); ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.Disable(GL_TEXTURE_2D);
    gl.Disable(GL_TEXTURE_CUBE_MAP);
  }
  if (gl.BindBuffer) gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  for (const GLenum name : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SWAP_BYTES}) gl.PixelStorei(name, 0);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelZoom(1, 1);
}

}  // namespace

Picture::Picture(const std::array<GLint, 4>& viewport) : viewport_(viewport), has_stencil_(get_integer(GL_STENCIL_BITS) > 0) {
  const Functions& gl = real();
  const auto pixels = static_cast<size_t>(viewport[2]) * static_cast<size_t>(viewport[3]);
  const auto read = [&](GLenum format, GLenum type, void* to) { gl.ReadPixels(viewport[0], viewport[1], viewport[2], viewport[3], format, type, to); };
  gl.PushClientAttrib(GL_CLIENT_PIXEL_STORE_BIT);
  if (gl.BindBuffer) gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  for (const GLenum name : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_SWAP_BYTES}) gl.PixelStorei(name, 0);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  colors_.resize(4 * pixels);
  depth_.resize(pixels);
  read(GL_RGBA, GL_UNSIGNED_BYTE, colors_.data());
  read(GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, depth_.data());
  if (has_stencil_) {
    stencil_.resize(pixels);
    read(GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil_.data());
  }
  gl.PopClientAttrib();
}

void Picture::restore() const {
  const Functions& gl = real();
  const auto draw = [&](GLenum format, GLenum type, const void* from) { gl.DrawPixels(viewport_[2], viewport_[3], format, type, from); };
  gl.PushAttrib(GL_ALL_ATTRIB_BITS);
  put_pixels_alone();
  gl.ColorMask(1, 1, 1, 1);
  gl.WindowPos2i(viewport_[0], viewport_[1]);
  draw(GL_RGBA, GL_UNSIGNED_BYTE, colors_.data());
  if (has_stencil_) {
    gl.StencilMask(~0u);
    draw(GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil_.data());
  }
  gl.ColorMask(0, 0, 0, 0);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_ALWAYS);
  gl.DepthMask(1);
  gl.DepthRange(0, 1);
  draw(GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, depth_.data());
  gl.PopAttrib();
}

bool Picture::write(const std::string& path) const {
  const auto width = static_cast<size_t>(viewport_[2]), height = static_cast<size_t>(viewport_[3]);
  std::vector<uint8_t> rows;
  rows.reserve(3 * width * height);
  for (size_t y = height; y-- > 0;)
    for (size_t x = 0; x < width; ++x) rows.insert(rows.end(), &colors_[4 * (y * width + x)], &colors_[4 * (y * width + x)] + 3);
  std::ofstream file(path, std::ios::binary);
  file << png(viewport_[2], viewport_[3], 3, rows);
  return file.good();
}

}  // namespace sideray::run
