// Checks before a .glb file is written that it can be read again (limits.h, docs/limits.md). Called by the writer; any
// thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Counts objects, lights, vertices and texels. Throws Error, which names `path` and the count that is too large.
void require_readable(const std::string& path, const Content& content);

// Counts JSON values as the reader does, while they are created, so that memory never holds more than the limit.
class JsonCount {
 public:
  explicit JsonCount(const std::string& path) : path_(path) {}
  // `depth`: the number of objects and lists around the value. Throws Error, which says how many `nodes` are too many.
  void add(const nlohmann::json& value, int depth, size_t nodes);

 private:
  std::string path_;
  uint64_t values_ = 0;
};

}  // namespace sideray::scenes
