#include "scenes/glb/glb_instances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>

#include "scenes/content/animation.h"

namespace sideray::scenes {
namespace {

struct Trs {
  float translation[3], rotation[4], scale[3];
};

// Returns translation, rotation and scale of an object; nothing where it is sheared, which they cannot express.
std::optional<Trs> trs_of(const Object& object) {
  constexpr double shear_tolerance = 1e-6, largest = 1e30, smallest = 1e-30;
  const double* m = object.world_from_object;
  glm::dmat3 axes(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  Trs trs;
  for (int c = 0; c < 3; ++c) {
    const double length = glm::length(axes[c]);
    if (!(length > smallest && length < largest && std::abs(m[9 + c]) < largest)) return std::nullopt;
    axes[c] /= length;
    trs.scale[c] = static_cast<float>(length);
    trs.translation[c] = static_cast<float>(m[9 + c]);
  }
  for (int c = 0; c < 3; ++c)
    if (!(std::abs(glm::dot(axes[c], axes[(c + 1) % 3])) <= shear_tolerance)) return std::nullopt;
  if (glm::determinant(axes) < 0.0) {
    axes[0] = -axes[0];
    trs.scale[0] = -trs.scale[0];
  }
  const glm::dquat q = glm::normalize(glm::quat_cast(axes));
  const double rotation[4] = {q.x, q.y, q.z, q.w};
  std::transform(rotation, rotation + 4, trs.rotation, [](double x) { return static_cast<float>(x); });
  return trs;
}

glm::dmat4 matrix_of(const Object& object) {
  glm::dmat4 m(1.0);
  for (int i = 0; i < 12; ++i) m[i / 3][i % 3] = object.world_from_object[i];
  return m;
}

// Returns for each object whether it can be an instance: it stands still and is not sheared.
std::vector<bool> can_be_instances(const Content& content) {
  std::vector<bool> can;
  can.reserve(content.objects.size());
  for (const Object& object : content.objects) can.push_back(trs_of(object).has_value());
  if (!content.rig) return can;
  std::vector<bool> is_skinned(content.meshes.size(), false);
  for (const SkinnedMesh& skinned : content.rig->skinned) is_skinned.at(skinned.mesh) = true;
  for (const Attached& moving : content.rig->objects) can.at(moving.index) = false;
  for (size_t i = 0; i < can.size(); ++i)
    if (is_skinned.at(content.objects[i].mesh)) can[i] = false;
  return can;
}

void append_row(const glm::dmat4& m, int row, std::vector<uint16_t>& parts) {
  for (int c = 0; c < 4; ++c) {
    const auto bits = std::bit_cast<uint64_t>(m[c][row]);
    for (int shift = 0; shift < 64; shift += 16) parts.push_back(static_cast<uint16_t>(bits >> shift & 0xffff));
  }
}

}  // namespace

glm::dmat4 instance_transform(const InstanceFloats& floats) {
  glm::dmat4 m(1.0);
  if (const float* r = floats.rotation) {
    const glm::dquat q(double{r[3]}, double{r[0]}, double{r[1]}, double{r[2]});
    if (glm::length(q) > 1e-6) m = glm::mat4_cast(glm::normalize(q));
  }
  for (int c = 0; c < 3; ++c) {
    if (floats.scale) m[c] *= double{floats.scale[c]};
    if (floats.translation) m[3][c] = double{floats.translation[c]};
  }
  return m;
}

std::vector<ObjectGroup> group_objects(const Content& content) {
  using Key = std::tuple<uint32_t, uint32_t, uint32_t, std::string_view>;
  const std::vector<bool> can_be_instance = can_be_instances(content);
  std::vector<ObjectGroup> alike;
  std::map<Key, size_t> known;
  for (uint32_t i = 0; i < content.objects.size(); ++i) {
    const Object& o = content.objects[i];
    size_t group = alike.size();
    if (can_be_instance[i]) group = known.try_emplace(Key{o.mesh, o.material, o.wind, o.name}, group).first->second;
    if (group == alike.size()) alike.emplace_back();
    alike[group].push_back(i);
  }
  std::vector<ObjectGroup> groups;
  for (ObjectGroup& group : alike) {
    if (group.size() >= fewest_instances)
      groups.push_back(std::move(group));
    else
      for (const uint32_t i : group) groups.push_back({i});
  }
  std::sort(groups.begin(), groups.end());
  return groups;
}

InstanceAttributes instance_attributes(const Content& content, const ObjectGroup& group) {
  InstanceAttributes attributes;
  bool is_exact[3] = {true, true, true};
  for (const uint32_t i : group) {
    const Object& object = content.objects[i];
    const Trs trs = trs_of(object).value();
    attributes.translations.insert(attributes.translations.end(), trs.translation, trs.translation + 3);
    attributes.rotations.insert(attributes.rotations.end(), trs.rotation, trs.rotation + 4);
    attributes.scales.insert(attributes.scales.end(), trs.scale, trs.scale + 3);
    if (object.wind != 0) attributes.wind_phases.push_back(object.wind_phase);
    attributes.object_indices.push_back(static_cast<float>(i));
    const glm::dmat4 m = matrix_of(object), rounded = instance_transform({trs.translation, trs.rotation, trs.scale});
    for (int row = 0; row < 3; ++row) {
      is_exact[row] = is_exact[row] && glm::row(m, row) == glm::row(rounded, row);
      append_row(m, row, attributes.matrix_rows[row]);
    }
  }
  for (int row = 0; row < 3; ++row)
    if (is_exact[row]) attributes.matrix_rows[row].clear();
  return attributes;
}

}  // namespace sideray::scenes
