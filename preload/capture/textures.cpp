#include "preload/capture/textures.h"

#include "preload/base/hash.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

// After so many reads a texture that keeps changing (a film, a picture of the scene) keeps its last contents and hash.
constexpr int most_reads = 4;
constexpr GLint largest = 4096;

}  // namespace

const Texture& Textures::find(GLuint name) {
  if (name == 0) return none_;
  Known& known = known_[name];
  if (known.stale && known.reads < most_reads) {
    read(name, known.texture);
    ++known.reads;
  }
  known.stale = false;
  return known.texture;
}

void Textures::changed(GLuint name) {
  if (const auto found = known_.find(name); found != known_.end()) found->second.stale = true;
}

void Textures::read(GLuint name, Texture& texture) {
  const Functions& gl = real();
  GLint bound = 0, pack_buffer = 0;
  gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  if (gl.BindBuffer) gl.GetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack_buffer);
  gl.BindTexture(GL_TEXTURE_2D, name);
  gl.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &texture.width);
  gl.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &texture.height);
  gl.GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, &texture.wrap[0]);
  gl.GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, &texture.wrap[1]);
  gl.GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, &texture.magnified);
  if (texture.width > 0 && texture.height > 0 && texture.width <= largest && texture.height <= largest) {
    texture.texels.resize(4 * static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height));
    gl.PushClientAttrib(GL_CLIENT_PIXEL_STORE_BIT);
    if (pack_buffer != 0) gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    for (const GLenum name_of_0 : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST})
      gl.PixelStorei(name_of_0, 0);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, texture.texels.data());
    gl.PopClientAttrib();
    if (pack_buffer != 0) gl.BindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack_buffer));
    texture.hash = hash_bytes(texture.texels.data(), texture.texels.size(), static_cast<uint64_t>(texture.width)) | 1u;
  }
  gl.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  texture.covers = true;
  for (size_t alpha = 3; alpha < texture.texels.size() && texture.covers; alpha += 4) texture.covers = texture.texels[alpha] >= 250;
}

}  // namespace sideray::run
