#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>
#include <sstream>

#include "elementary/functions.h"
#include "scenes/base/files.h"
#include "scenes/content/content.h"
#include "scenes/content/placement.h"

namespace sideray::scenes {
namespace {

constexpr float smooth_roughness = 0.5f;

bool can_be_traced(const Material& material) {
  const sideray_material_desc& desc = material.desc;
  const bool blended = desc.alpha_mode == SIDERAY_BLEND;
  if (blended && desc.blend_mode == SIDERAY_BLEND_MULTIPLY) return false;
  return blended || desc.transmission > 0.0f;
}

// Returns the mean of the texture's roughness, 1 where there is none.
double mean_roughness(const Content& content, const sideray_texture_slot& slot) {
  if (slot.texture == 0 || slot.texture > content.textures.size()) return 1.0;
  const std::vector<uint8_t>& rgba = content.textures[slot.texture - 1].rgba;
  if (rgba.size() < 4) return 1.0;
  uint64_t sum = 0;
  for (size_t i = 1; i < rgba.size(); i += 4) sum += rgba[i];
  return static_cast<double>(sum) / (255.0 * static_cast<double>(rgba.size() / 4));
}

// Returns whether `auto` traces the material. It traces all transmission, also of rough glass: only rays blur the view
// through it. It does not trace rough blended surfaces: blending shows the background in place, and rays hardly change
// rough reflections.
bool traced_by_itself(const Content& content, const Material& material) {
  if (material.ray_traced != RayTraced::by_default) return material.ray_traced == RayTraced::yes;
  if (material.desc.transmission > 0.0f) return true;
  const double texture = mean_roughness(content, material.desc.metallic_roughness_texture);
  return double{material.desc.roughness} * texture < double{smooth_roughness};
}

// Returns the area in pixels of the rectangle around the object's visible part.
double screen_area(const Bounds& world, const sideray_camera& camera, uint32_t width, uint32_t height) {
  if (world.empty()) return 0.0;
  const double* m = camera.world_from_camera;
  const glm::dmat3 world_from_camera(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  const glm::dvec3 eye(m[9], m[10], m[11]);
  const double aspect = static_cast<double>(width) / height;
  const double half_height =
      camera.orthographic != 0 ? double{camera.half_height} : elementary::tan(0.5 * double{camera.yfov});
  const glm::dvec2 stretch(camera.fx_per_fy > 0.0f ? double{camera.fx_per_fy} : 1.0, 1.0);
  glm::dvec2 low(INFINITY), high(-INFINITY);
  bool behind = false;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p((corner & 1) != 0 ? world.maximum.x : world.minimum.x,
                       (corner & 2) != 0 ? world.maximum.y : world.minimum.y,
                       (corner & 4) != 0 ? world.maximum.z : world.minimum.z);
    const glm::dvec3 view = glm::transpose(world_from_camera) * (p - eye);
    const double depth = camera.orthographic != 0 ? 1.0 : -view.z;
    behind = behind || -view.z <= double{camera.z_near};
    const glm::dvec2 screen = stretch * glm::dvec2(view) / (std::max(depth, 1e-9) * half_height * glm::dvec2(aspect, 1.0)) +
                              glm::dvec2(2.0 * double{camera.shift_x}, -2.0 * double{camera.shift_y});
    if (-view.z > double{camera.z_near}) low = glm::min(low, screen), high = glm::max(high, screen);
  }
  if (low.x > high.x) return 0.0;
  // A box that reaches behind the camera has no finite outline: its rectangle covers the whole picture.
  if (behind) low = glm::min(low, glm::dvec2(-1)), high = glm::max(high, glm::dvec2(1));
  const glm::dvec2 size = glm::clamp(high, -1.0, 1.0) - glm::clamp(low, -1.0, 1.0);
  return 0.25 * size.x * size.y * width * height;
}

std::vector<bool> largest(const Content& content, const std::vector<bool>& candidates, size_t count,
                          const sideray_camera& camera, uint32_t width, uint32_t height) {
  std::vector<double> areas(content.objects.size(), 0.0);
  std::vector<size_t> order;
  for (size_t i = 0; i < content.objects.size(); ++i) {
    if (!candidates[i]) continue;
    areas[i] = screen_area(bounds_of(content, content.objects[i]), camera, width, height);
    order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return areas[a] > areas[b]; });
  std::vector<bool> traced(content.objects.size(), false);
  for (size_t i = 0; i < std::min(count, order.size()); ++i) traced[order[i]] = true;
  return traced;
}

size_t parse_count(const std::string& text) {
  size_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) {
    refuse("--ray-traced largest:{}: not a whole number; give for example largest:8", text);
  }
  return count;
}

std::vector<bool> matching(const Content& content, const std::vector<bool>& candidates, const std::string& patterns) {
  std::vector<bool> traced(content.objects.size(), false);
  std::stringstream list(patterns);
  std::string pattern;
  size_t count = 0;
  while (std::getline(list, pattern, ',')) {
    ++count;
    bool named = false, used = false;
    for (size_t i = 0; i < content.objects.size(); ++i) {
      if (fnmatch(pattern.c_str(), content.objects[i].name.c_str(), 0) != 0) continue;
      named = true;
      if (!candidates[i]) continue;
      traced[i] = used = true;
    }
    if (!used) {
      refuse(
          "--ray-traced {}: {}; use a name of the translucent objects in `sideray info SCENE`, or auto, all, none, "
          "largest:K",
          pattern,
          named ? "no object of that name can be ray traced (translucent, not multiply)" : "no object has such a name");
    }
  }
  if (count == 0) refuse("--ray-traced: nothing is given; use auto, all, none, largest:K or names");
  return traced;
}

}  // namespace

std::vector<bool> select_ray_traced(const Content& content, const std::string& selection, const sideray_camera& camera,
                                    uint32_t width, uint32_t height) {
  std::vector<bool> material_traced;
  for (const Material& material : content.materials)
    material_traced.push_back(can_be_traced(material) && traced_by_itself(content, material));
  std::vector<bool> candidates, by_itself;
  for (const Object& object : content.objects) {
    const bool is_surface = content.meshes.at(object.mesh).topology == SIDERAY_TRIANGLES;
    candidates.push_back(is_surface && can_be_traced(content.materials.at(object.material)));
    by_itself.push_back(is_surface && material_traced[object.material]);
  }
  if (selection == "auto") return by_itself;
  if (selection == "all") return candidates;
  if (selection == "none") return std::vector<bool>(content.objects.size(), false);
  const std::string largest_prefix = "largest:";
  if (selection.starts_with(largest_prefix)) {
    const size_t count = parse_count(selection.substr(largest_prefix.size()));
    return largest(content, candidates, count, camera, width, height);
  }
  return matching(content, candidates, selection);
}

}  // namespace sideray::scenes
