#include "preload/capture/attributes.h"

#include "preload/gl/functions.h"

namespace sideray::run {

Vertex read_attributes() {
  const Functions& gl = real();
  Vertex vertex;
  gl.GetFloatv(GL_CURRENT_COLOR, vertex.color);
  gl.GetFloatv(GL_CURRENT_NORMAL, vertex.normal);
  GLint active = GL_TEXTURE0;
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (int unit = 0; unit < texture_units(); ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.GetFloatv(GL_CURRENT_TEXTURE_COORDS, vertex.uv[unit]);
  }
  gl.ActiveTexture(static_cast<GLenum>(active));
  return vertex;
}

}  // namespace sideray::run
