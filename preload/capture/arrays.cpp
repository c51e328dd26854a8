#include "preload/capture/arrays.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "preload/capture/attributes.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

size_t size_of(GLenum type) {
  switch (type) {
    case GL_BYTE:
    case GL_UNSIGNED_BYTE:
      return 1;
    case GL_SHORT:
    case GL_UNSIGNED_SHORT:
    case GL_HALF_FLOAT:
      return 2;
    case GL_DOUBLE:
      return 8;
    default:
      return 4;
  }
}

template <typename T>
float load(const char* at, bool is_normalized) {
  T value;
  std::memcpy(&value, at, sizeof(value));
  return is_normalized ? normalized(value) : static_cast<float>(value);
}

float component(const char* at, GLenum type, bool is_normalized) {
  switch (type) {
    case GL_BYTE:
      return load<GLbyte>(at, is_normalized);
    case GL_UNSIGNED_BYTE:
      return load<GLubyte>(at, is_normalized);
    case GL_SHORT:
      return load<GLshort>(at, is_normalized);
    case GL_UNSIGNED_SHORT:
      return load<GLushort>(at, is_normalized);
    case GL_INT:
      return load<GLint>(at, is_normalized);
    case GL_UNSIGNED_INT:
      return load<GLuint>(at, is_normalized);
    case GL_DOUBLE:
      return load<GLdouble>(at, is_normalized);
    default:
      return load<GLfloat>(at, is_normalized);
  }
}

uint32_t index_at(const char* data, GLenum type, size_t i) {
  if (type == GL_UNSIGNED_BYTE) return static_cast<unsigned char>(data[i]);
  if (type == GL_UNSIGNED_SHORT) {
    uint16_t value;
    std::memcpy(&value, data + 2 * i, sizeof(value));
    return value;
  }
  uint32_t value;
  std::memcpy(&value, data + 4 * i, sizeof(value));
  return value;
}

}  // namespace

const std::vector<char>& Arrays::buffer(GLuint name) {
  const auto found = buffers_.find(name);
  if (found != buffers_.end()) return found->second;
  const Functions& gl = real();
  std::vector<char>& bytes = buffers_[name];
  const auto bound = static_cast<GLuint>(get_integer(GL_ARRAY_BUFFER_BINDING));
  gl.BindBuffer(GL_ARRAY_BUFFER, name);
  GLint size = 0;
  gl.GetBufferParameteriv(GL_ARRAY_BUFFER, GL_BUFFER_SIZE, &size);
  bytes.resize(static_cast<size_t>(std::max(size, 0)));
  if (size > 0) gl.GetBufferSubData(GL_ARRAY_BUFFER, 0, size, bytes.data());
  gl.BindBuffer(GL_ARRAY_BUFFER, bound);
  return bytes;
}

Arrays::Array Arrays::find(GLenum array, GLenum size, GLenum type, GLenum stride, GLenum pointer, GLenum buffer_binding) {
  const Functions& gl = real();
  Array found;
  if (!gl.IsEnabled(array)) return found;
  found.size = size == 0 ? 3 : get_integer(size);
  found.type = static_cast<GLenum>(get_integer(type));
  found.stride = static_cast<size_t>(get_integer(stride));
  if (found.stride == 0) found.stride = size_of(found.type) * static_cast<size_t>(found.size);
  void* data = nullptr;
  gl.GetPointerv(pointer, &data);
  found.data = static_cast<const char*>(data);
  const auto name = static_cast<GLuint>(gl.BindBuffer ? get_integer(buffer_binding) : 0);
  if (name == 0) return found;
  const std::vector<char>& bytes = buffer(name);
  found.data = bytes.data() + reinterpret_cast<size_t>(data);
  found.end = bytes.data() + bytes.size();
  return found;
}

void Arrays::fill(std::vector<Vertex>& vertices, const std::vector<uint32_t>& places) {
  const Functions& gl = real();
  const auto take = [&](const Array& array, bool is_normalized, auto&& target) {
    if (!array.data) return;
    const size_t component_size = size_of(array.type);
    const size_t element = component_size * static_cast<size_t>(array.size);
    for (size_t i = 0; i < vertices.size(); ++i) {
      const char* at = array.data + places[i] * array.stride;
      if (array.end && at + element > array.end) return;
      float* values = target(vertices[i]);
      for (int c = 0; c < array.size; ++c) values[c] = component(at + static_cast<size_t>(c) * component_size, array.type, is_normalized);
    }
  };
  const Array color = find(GL_COLOR_ARRAY, GL_COLOR_ARRAY_SIZE, GL_COLOR_ARRAY_TYPE, GL_COLOR_ARRAY_STRIDE, GL_COLOR_ARRAY_POINTER,
                           GL_COLOR_ARRAY_BUFFER_BINDING);
  if (color.data && color.size == 3)
    for (Vertex& vertex : vertices) vertex.color[3] = 1;
  take(color, true, [](Vertex& v) { return v.color; });
  take(find(GL_NORMAL_ARRAY, 0, GL_NORMAL_ARRAY_TYPE, GL_NORMAL_ARRAY_STRIDE, GL_NORMAL_ARRAY_POINTER, GL_NORMAL_ARRAY_BUFFER_BINDING),
       true, [](Vertex& v) { return v.normal; });
  take(find(GL_VERTEX_ARRAY, GL_VERTEX_ARRAY_SIZE, GL_VERTEX_ARRAY_TYPE, GL_VERTEX_ARRAY_STRIDE, GL_VERTEX_ARRAY_POINTER,
            GL_VERTEX_ARRAY_BUFFER_BINDING),
       false, [](Vertex& v) { return v.position; });
  const auto active = static_cast<GLenum>(get_integer(GL_CLIENT_ACTIVE_TEXTURE));
  for (GLenum unit = 0; unit < 2; ++unit) {
    gl.ClientActiveTexture(GL_TEXTURE0 + unit);
    const Array uv = find(GL_TEXTURE_COORD_ARRAY, GL_TEXTURE_COORD_ARRAY_SIZE, GL_TEXTURE_COORD_ARRAY_TYPE, GL_TEXTURE_COORD_ARRAY_STRIDE,
                          GL_TEXTURE_COORD_ARRAY_POINTER, GL_TEXTURE_COORD_ARRAY_BUFFER_BINDING);
    if (uv.data)
      for (Vertex& vertex : vertices) vertex.uv[unit][1] = vertex.uv[unit][2] = 0, vertex.uv[unit][3] = 1;
    take(uv, false, [unit](Vertex& v) { return v.uv[unit]; });
  }
  gl.ClientActiveTexture(active);
}

Geometry Arrays::read(GLenum mode, GLint first, GLsizei count) {
  Geometry geometry;
  geometry.mode = mode;
  geometry.vertices.assign(static_cast<size_t>(std::max(count, 0)), read_attributes());
  std::vector<uint32_t> places(geometry.vertices.size());
  std::iota(places.begin(), places.end(), static_cast<uint32_t>(std::max(first, 0)));
  fill(geometry.vertices, places);
  return geometry;
}

std::optional<Geometry> Arrays::read_indexed(GLenum mode, GLsizei count, GLenum type, const void* indices) {
  if (type != GL_UNSIGNED_BYTE && type != GL_UNSIGNED_SHORT && type != GL_UNSIGNED_INT) return std::nullopt;
  const char* data = static_cast<const char*>(indices);
  const auto length = static_cast<size_t>(std::max(count, 0));
  if (const auto name = static_cast<GLuint>(real().BindBuffer ? get_integer(GL_ELEMENT_ARRAY_BUFFER_BINDING) : 0); name != 0) {
    const std::vector<char>& bytes = buffer(name);
    const size_t offset = reinterpret_cast<size_t>(indices);
    if (offset + length * size_of(type) > bytes.size()) return std::nullopt;
    data = bytes.data() + offset;
  }
  Geometry geometry;
  geometry.mode = mode;
  if (length == 0) return geometry;
  geometry.indices.resize(length);
  for (size_t i = 0; i < length; ++i) geometry.indices[i] = index_at(data, type, i);
  // The vertices that are named, and no others: many draws share one buffer.
  std::vector<uint32_t> places = geometry.indices;
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  for (uint32_t& index : geometry.indices)
    index = static_cast<uint32_t>(std::lower_bound(places.begin(), places.end(), index) - places.begin());
  geometry.vertices.assign(places.size(), read_attributes());
  fill(geometry.vertices, places);
  return geometry;
}

}  // namespace sideray::run
