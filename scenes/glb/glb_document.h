// Holds the two chunks of a GLB file while it is written: the JSON and the binary data. Numbers go into the JSON as
// doubles, which it keeps exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace sideray::scenes {

class GlbDocument {
 public:
  using Json = nlohmann::json;
  enum ComponentType : int { type_ushort = 5123, type_uint = 5125, type_float = 5126 };

  Json& root() { return root_; }

  // Appends bytes to the binary chunk and returns the index of their buffer view.
  size_t add_view(const void* data, size_t size);
  // Appends `count` elements of 1 to 4 or 16 components, and returns the index of their accessor.
  size_t add_accessor(const void* data, size_t count, size_t components, ComponentType type);
  // Adds an accessor of floats under a name, if there are any.
  void add_attribute(Json& attributes, const char* name, const std::vector<float>& values, size_t components);

  // Returns an extension of an object, {} at first, and lists its name.
  Json& extension(Json& object, const char* name);

  // Lists what was added to the document beside its nodes. Call it last, once.
  void finish();
  // Returns the file; `path` is for messages.
  std::vector<uint8_t> bytes(const std::string& path);

 private:
  Json root_ = Json::object();
  std::vector<uint8_t> binary_;
  std::set<std::string> extensions_;
};

}  // namespace sideray::scenes
