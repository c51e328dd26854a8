#include "bridge/reflection_texture.h"

#include "model/failure.h"

namespace sideray::bridge {

uint64_t ReflectionTexture::upload(const gl::Functions& gl, const rt::ReflectionImage& image, bool persistent) {
  if (width_ != image.width || height_ != image.height) {
    texture_ = gl::Texture(gl);
    width_ = image.width, height_ = image.height;
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    gl.BindTexture(GL_TEXTURE_2D, texture_.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), 0, GL_RGBA,
                  GL_HALF_FLOAT, nullptr);
    if (gl.GetError() != GL_NO_ERROR) {
      abandon();
      fail(SIDERAY_OUT_OF_MEMORY, "reflections of {}x{}: the driver has no room; lower the resolution", image.width,
           image.height);
    }
  }
  const TexturePiece all{
      GL_TEXTURE_2D, texture_.id(),           0,
      half4,         {0, 0, width_, height_}, reinterpret_cast<const std::byte*>(image.radiance.data()),
      width_};
  return upload_.send(gl, {&all, 1}, persistent);
}

void ReflectionTexture::abandon() {
  texture_.abandon();
  upload_.abandon();
  width_ = height_ = 0;
}

}  // namespace sideray::bridge
