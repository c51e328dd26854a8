// Gives surfaces numbers that stay from frame to frame, so that an answer of an earlier frame finds its surface.
#pragma once

#include <cstdint>
#include <map>
#include <set>

namespace sideray::run {

class SurfaceNames {
 public:
  void begin_frame();
  // Returns the id of a surface of this frame: the id that the same mesh had in the previous frame, or else the id of a
  // surface with the same texture, because a program may make vertices anew. Texture 0 matches none.
  uint32_t name(uint64_t mesh, uint64_t texture);

 private:
  using Names = std::multimap<uint64_t, uint32_t>;
  uint32_t take_old(Names& names, uint64_t key);

  Names meshes_, textures_, old_meshes_, old_textures_;
  std::set<uint32_t> taken_;  // in this frame
  uint32_t next_ = 1;
};

}  // namespace sideray::run
