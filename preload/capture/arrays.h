// Reads the vertices of a draw from vertex arrays and buffers.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "preload/capture/geometry.h"

namespace sideray::run {

class Arrays {
 public:
  // Reads the vertices `first` to first + count - 1 of the enabled arrays.
  std::shared_ptr<const Geometry> read(GLenum mode, GLint first, GLsizei count);
  // Reads the vertices that indices name. Returns null if the type of the indices is not one of OpenGL's, or if they
  // lie outside their buffer.
  std::shared_ptr<const Geometry> read_indexed(GLenum mode, GLsizei count, GLenum type, const void* indices);
  // Notes that the contents of a buffer changed.
  void changed(GLuint buffer) { buffers_.erase(buffer); }
  void clear() { buffers_.clear(), kept_.clear(); }

 private:
  struct Buffer {
    std::vector<char> bytes;
    uint64_t version = 0;  // unique among all contents of all buffers
  };
  struct Array {
    const char* data = nullptr;  // null: not enabled
    const char* end = nullptr;   // of its buffer; null: it lies in the program's memory
    uint64_t version = 0;        // of its buffer; 0 = none
    GLint size = 4;
    GLenum type = GL_FLOAT;
    size_t stride = 0;
  };
  // Holds the enabled arrays, and the current attributes in place of the others.
  struct Source {
    Array position, normal, color, uv[kept_units];
    Vertex current;
  };
  static constexpr size_t most_kept = 4096;

  Source find_source();
  Array find(GLenum array, GLenum size, GLenum type, GLenum stride, GLenum pointer, GLenum buffer);
  const Buffer& buffer(GLuint name);
  // Returns vertices; vertex i is the arrays' element places[i].
  static std::vector<Vertex> fetch(const Source& source, const std::vector<uint32_t>& places);
  static void hash_source(const Source& source, uint64_t& hash, bool& lies_in_buffers);
  // Returns the geometry that `make` makes; if all of it lies in buffers, it is made only once.
  template <typename Make>
  std::shared_ptr<const Geometry> keep(const Source& source, uint64_t draw, bool lies_in_buffers, Make&& make);

  uint64_t next_version_ = 1;
  std::map<GLuint, Buffer> buffers_;
  std::unordered_map<uint64_t, std::shared_ptr<const Geometry>> kept_;
};

}  // namespace sideray::run
