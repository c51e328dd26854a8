// Checks that a .glb file will be read again (limits.h, docs/limits.md) before it is written. Called by the writer; any
// thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Counts objects, lights, vertices and texels. Throws Error, which names `path` and what is too much.
void require_readable(const std::string& path, const Content& content);

// Counts JSON values as the reader does, while they are made, so that no more than the limit is ever in memory.
class JsonCount {
 public:
  explicit JsonCount(const std::string& path) : path_(path) {}
  // `depth`: how many objects and lists are around the value. Throws Error, which says how many `nodes` are too many.
  void add(const nlohmann::json& value, int depth, size_t nodes);

 private:
  std::string path_;
  uint64_t values_ = 0;
};

}  // namespace sideray::scenes
