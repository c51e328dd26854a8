#include "preload/capture/arrays.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "preload/base/hash.h"
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

// Renumbers the indices so that unused vertices are left out, since many draws share one buffer. Returns the places of
// the used ones.
std::vector<uint32_t> compact(std::vector<uint32_t>& indices) {
  const auto [least, most] = std::minmax_element(indices.begin(), indices.end());
  const uint32_t first = *least;
  const size_t range = size_t{*most} - first + 1;
  std::vector<uint32_t> places;
  if (range <= 16 * indices.size() + 4096) {
    std::vector<uint32_t> place_of(range, 0);
    for (const uint32_t index : indices) place_of[index - first] = 1;
    for (size_t i = 0; i < range; ++i)
      if (place_of[i] != 0) place_of[i] = static_cast<uint32_t>(places.size()), places.push_back(first + static_cast<uint32_t>(i));
    for (uint32_t& index : indices) index = place_of[index - first];
    return places;
  }
  places = indices;
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  for (uint32_t& index : indices) index = static_cast<uint32_t>(std::lower_bound(places.begin(), places.end(), index) - places.begin());
  return places;
}

}  // namespace

const Arrays::Buffer& Arrays::buffer(GLuint name) {
  const auto found = buffers_.find(name);
  if (found != buffers_.end()) return found->second;
  const Functions& gl = real();
  Buffer& read = buffers_[name];
  read.version = next_version_++;
  const auto bound = static_cast<GLuint>(get_integer(GL_ARRAY_BUFFER_BINDING));
  gl.BindBuffer(GL_ARRAY_BUFFER, name);
  GLint size = 0;
  gl.GetBufferParameteriv(GL_ARRAY_BUFFER, GL_BUFFER_SIZE, &size);
  read.bytes.resize(static_cast<size_t>(std::max(size, 0)));
  if (size > 0) gl.GetBufferSubData(GL_ARRAY_BUFFER, 0, size, read.bytes.data());
  gl.BindBuffer(GL_ARRAY_BUFFER, bound);
  return read;
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
  const Buffer& read = buffer(name);
  found.version = read.version;
  found.data = read.bytes.data() + reinterpret_cast<size_t>(data);
  found.end = read.bytes.data() + read.bytes.size();
  return found;
}

Arrays::Source Arrays::find_source() {
  const Functions& gl = real();
  Source source;
  source.current = read_attributes();
  source.color = find(GL_COLOR_ARRAY, GL_COLOR_ARRAY_SIZE, GL_COLOR_ARRAY_TYPE, GL_COLOR_ARRAY_STRIDE, GL_COLOR_ARRAY_POINTER,
                      GL_COLOR_ARRAY_BUFFER_BINDING);
  source.normal = find(GL_NORMAL_ARRAY, 0, GL_NORMAL_ARRAY_TYPE, GL_NORMAL_ARRAY_STRIDE, GL_NORMAL_ARRAY_POINTER,
                       GL_NORMAL_ARRAY_BUFFER_BINDING);
  source.position = find(GL_VERTEX_ARRAY, GL_VERTEX_ARRAY_SIZE, GL_VERTEX_ARRAY_TYPE, GL_VERTEX_ARRAY_STRIDE, GL_VERTEX_ARRAY_POINTER,
                         GL_VERTEX_ARRAY_BUFFER_BINDING);
  const auto active = static_cast<GLenum>(get_integer(GL_CLIENT_ACTIVE_TEXTURE));
  for (int unit = 0; unit < texture_units(); ++unit) {
    gl.ClientActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    source.uv[unit] = find(GL_TEXTURE_COORD_ARRAY, GL_TEXTURE_COORD_ARRAY_SIZE, GL_TEXTURE_COORD_ARRAY_TYPE, GL_TEXTURE_COORD_ARRAY_STRIDE,
                           GL_TEXTURE_COORD_ARRAY_POINTER, GL_TEXTURE_COORD_ARRAY_BUFFER_BINDING);
  }
  gl.ClientActiveTexture(active);
  return source;
}

std::vector<Vertex> Arrays::fetch(const Source& source, const std::vector<uint32_t>& places) {
  std::vector<Vertex> vertices(places.size(), source.current);
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
  if (source.color.data && source.color.size == 3)
    for (Vertex& vertex : vertices) vertex.color[3] = 1;
  take(source.color, true, [](Vertex& v) { return v.color; });
  take(source.normal, true, [](Vertex& v) { return v.normal; });
  take(source.position, false, [](Vertex& v) { return v.position; });
  for (size_t unit = 0; unit < kept_units; ++unit) {
    if (source.uv[unit].data)
      for (Vertex& vertex : vertices) vertex.uv[unit][1] = vertex.uv[unit][2] = 0, vertex.uv[unit][3] = 1;
    take(source.uv[unit], false, [unit](Vertex& v) { return v.uv[unit]; });
  }
  return vertices;
}

void Arrays::hash_source(const Source& source, uint64_t& hash, bool& lies_in_buffers) {
  const auto add = [&](const Array& array) {
    if (array.data && array.version == 0) lies_in_buffers = false;
    const size_t place = array.version == 0 ? 0 : static_cast<size_t>(array.end - array.data);
    for (const uint64_t word : {array.version, uint64_t{place}, uint64_t{array.type}, static_cast<uint64_t>(array.size), uint64_t{array.stride}})
      hash = mix(hash, word);
  };
  for (const Array* array : {&source.position, &source.normal, &source.color}) add(*array);
  for (const Array& array : source.uv) add(array);
  hash = hash_bytes(&source.current, sizeof(source.current), hash);
}

template <typename Make>
std::shared_ptr<const Geometry> Arrays::keep(const Source& source, uint64_t draw, bool lies_in_buffers, Make&& make) {
  hash_source(source, draw, lies_in_buffers);
  if (lies_in_buffers)
    if (const auto found = kept_.find(draw); found != kept_.end()) return found->second;
  std::shared_ptr<const Geometry> made = std::make_shared<const Geometry>(make());
  if (!lies_in_buffers) return made;
  if (kept_.size() >= most_kept) kept_.clear();
  kept_.emplace(draw, made);
  return made;
}

std::shared_ptr<const Geometry> Arrays::read(GLenum mode, GLint first, GLsizei count) {
  const Source source = find_source();
  const uint64_t draw = mix(mix(mode, static_cast<uint64_t>(first)), static_cast<uint64_t>(count));
  return keep(source, draw, true, [&] {
    Geometry geometry;
    geometry.mode = mode;
    std::vector<uint32_t> places(static_cast<size_t>(std::max(count, 0)));
    std::iota(places.begin(), places.end(), static_cast<uint32_t>(std::max(first, 0)));
    geometry.vertices = fetch(source, places);
    return geometry;
  });
}

std::shared_ptr<const Geometry> Arrays::read_indexed(GLenum mode, GLsizei count, GLenum type, const void* indices) {
  if (type != GL_UNSIGNED_BYTE && type != GL_UNSIGNED_SHORT && type != GL_UNSIGNED_INT) return {};
  const char* data = static_cast<const char*>(indices);
  const auto length = static_cast<size_t>(std::max(count, 0));
  uint64_t version = 0;
  const auto offset = reinterpret_cast<size_t>(indices);
  if (const auto name = static_cast<GLuint>(real().BindBuffer ? get_integer(GL_ELEMENT_ARRAY_BUFFER_BINDING) : 0); name != 0) {
    const Buffer& read = buffer(name);
    if (offset + length * size_of(type) > read.bytes.size()) return {};
    data = read.bytes.data() + offset;
    version = read.version;
  }
  const Source source = find_source();
  const uint64_t draw = mix(mix(mix(mix(mode, type), version), offset), length);
  return keep(source, draw, version != 0, [&] {
    Geometry geometry;
    geometry.mode = mode;
    geometry.indices.resize(length);
    for (size_t i = 0; i < length; ++i) geometry.indices[i] = index_at(data, type, i);
    if (length > 0) geometry.vertices = fetch(source, compact(geometry.indices));
    return geometry;
  });
}

}  // namespace sideray::run
