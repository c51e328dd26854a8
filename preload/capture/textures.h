// Holds the program's 2D textures, which are read back at their first use and named by a hash of their contents.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "preload/gl/entry_points.h"

namespace sideray::run {

struct Texture {
  uint64_t hash = 0;   // 0 = no texture
  bool covers = true;  // no texel is translucent
  GLint width = 0, height = 0;
  GLint wrap[2] = {GL_REPEAT, GL_REPEAT}, magnified = GL_LINEAR;  // when its texels were read
  std::vector<uint8_t> texels;  // RGBA, rows as OpenGL is given them
};

class Textures {
 public:
  // Returns a texture, and reads it if it is new or changed. It need not be bound. Name 0: no texture, with hash 0.
  const Texture& find(GLuint name);
  void changed(GLuint name);
  void deleted(GLuint name) { known_.erase(name); }
  void clear() { known_.clear(); }

 private:
  struct Known {
    Texture texture;
    bool stale = true;
    int reads = 0;
  };
  static void read(GLuint name, Texture& texture);
  std::map<GLuint, Known> known_;
  const Texture none_{};
};

}  // namespace sideray::run
