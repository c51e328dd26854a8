// Checks before a .glb file is written that it will be within the limits of reading (limits.h, docs/limits.md). The
// writer calls it; any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Throws Error, which names `path`, where there are too many objects, lights, vertices or texels.
void require_readable(const std::string& path, const Content& content);

// Counts JSON values as the reader does while they are made, so that memory never holds more than the limit.
class JsonCount {
 public:
  explicit JsonCount(const std::string& path) : path_(path) {}
  // Counts the values in `value`, which is inside `depth` objects and lists. Throws Error, which states `nodes`, if
  // there are too many.
  void add(const nlohmann::json& value, int depth, size_t nodes);

 private:
  std::string path_;
  uint64_t values_ = 0;
};

}  // namespace sideray::scenes
