#include "scenes/glb/glb_limits.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"

namespace sideray::scenes {
namespace {

struct Amount {
  const char* of;
  uint64_t count, limit;
  const char* remedy;
};

uint64_t largest_mesh(const Content& content) {
  size_t largest = 0;
  for (const Mesh& mesh : content.meshes) largest = std::max({largest, mesh.positions.size() / 3, mesh.indices.size()});
  return largest;
}

uint64_t numbers_in_meshes(const Content& content) {
  uint64_t numbers = 0;
  for (const Mesh& m : content.meshes)
    numbers += m.positions.size() + m.normals.size() + m.tangents.size() + m.uv0.size() + m.uv1.size() +
               m.colors.size() + m.indices.size();
  return numbers;
}

uint64_t texels(const Content& content) {
  uint64_t sum = 0;
  for (const Texture& texture : content.textures) sum += uint64_t{texture.width} * texture.height;
  return sum;
}

uint64_t largest_side(const Content& content) {
  uint32_t side = 0;
  for (const Texture& texture : content.textures) side = std::max({side, texture.width, texture.height});
  return side;
}

}  // namespace

void require_readable(const std::string& path, const Content& content) {
  const Amount amounts[] = {
      {"objects", content.objects.size(), limits::objects, "make fewer"},
      {"lights", content.lights.size(), limits::lights, "make fewer"},
      {"vertices or indices in a mesh", largest_mesh(content), limits::accessor_elements, "split it"},
      {"numbers in its meshes", numbers_in_meshes(content), limits::mesh_numbers, "make fewer or coarser ones"},
      {"pixels along a side of a texture", largest_side(content), limits::picture_side, "make it smaller"},
      {"texels in its textures", texels(content), limits::texels, "make them smaller"}};
  for (const Amount& amount : amounts) {
    if (amount.count > amount.limit)
      refuse("cannot write {}: it would have {} {}, and {} are the most that is read; {}", path, amount.count,
             amount.of, amount.limit, amount.remedy);
  }
  for (const Object& object : content.objects) {
    for (const double x : object.world_from_object) {
      if (!(std::abs(x) <= limits::coordinate))
        refuse("cannot write {}: object {} is placed at {:g}, and 1e15 is the most that is read; move it closer", path,
               object.name, x);
    }
  }
}

void JsonCount::add(const nlohmann::json& value, int depth, size_t nodes) {
  if (depth > limits::json_depth)
    refuse("cannot write {}: its JSON would be nested deeper than the {} that are read; nest its extras less", path_,
           limits::json_depth);
  if (++values_ > limits::json_values)
    refuse(
        "cannot write {}: its JSON would have more than the {} values that are read, {} nodes among them; make fewer "
        "objects, or more of the same mesh, material and name",
        path_, limits::json_values, nodes);
  if (!value.is_structured()) return;
  if (value.is_object()) values_ += value.size();  // the keys
  for (const nlohmann::json& child : value) add(child, depth + 1, nodes);
}

}  // namespace sideray::scenes
