// Vertex arrays and buffers: what a draw reads from them.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "preload/capture/geometry.h"

namespace sideray::run {

class Arrays {
 public:
  // Vertices first .. first + count - 1 of the enabled arrays.
  Geometry read(GLenum mode, GLint first, GLsizei count);
  // The vertices that indices name. Empty where the type of the indices is none of OpenGL's.
  std::optional<Geometry> read_indexed(GLenum mode, GLsizei count, GLenum type, const void* indices);
  // The contents of the buffer changed.
  void changed(GLuint buffer) { buffers_.erase(buffer); }
  void clear() { buffers_.clear(); }

 private:
  struct Array {
    const char* data = nullptr;  // null: not enabled
    const char* end = nullptr;   // of its buffer; null: it lies in the program's memory
    GLint size = 4;
    GLenum type = GL_FLOAT;
    size_t stride = 0;
  };
  Array find(GLenum array, GLenum size, GLenum type, GLenum stride, GLenum pointer, GLenum buffer);
  const std::vector<char>& buffer(GLuint name);
  // Vertex i is the arrays' element places[i].
  void fill(std::vector<Vertex>& vertices, const std::vector<uint32_t>& places);

  std::map<GLuint, std::vector<char>> buffers_;
};

}  // namespace sideray::run
