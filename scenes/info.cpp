#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sideray/plan.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "elementary/functions.h"
#include "scenes/base/files.h"
#include "scenes/base/material_slots.h"
#include "scenes/content/content.h"
#include "scenes/content/placement.h"

namespace sideray::scenes {
namespace {

using Json = nlohmann::ordered_json;

const char* type_name(sideray_light_type type) {
  switch (type) {
    case SIDERAY_LIGHT_DIRECTIONAL:
      return "directional";
    case SIDERAY_LIGHT_POINT:
      return "point";
    case SIDERAY_LIGHT_SPOT:
      return "spot";
  }
  return "unknown";
}

const char* mode_name(sideray_alpha_mode mode) {
  switch (mode) {
    case SIDERAY_OPAQUE:
      return "opaque";
    case SIDERAY_MASK:
      return "mask";
    case SIDERAY_BLEND:
      return "blend";
  }
  return "unknown";
}

const char* blend_name(sideray_blend_mode mode) {
  switch (mode) {
    case SIDERAY_BLEND_ALPHA:
      return "alpha";
    case SIDERAY_BLEND_PREMULTIPLIED:
      return "premultiplied";
    case SIDERAY_BLEND_ADDITIVE:
      return "additive";
    case SIDERAY_BLEND_MULTIPLY:
      return "multiply";
  }
  return "unknown";
}

const char* mark_name(RayTraced mark) {
  switch (mark) {
    case RayTraced::by_default:
      return "default";
    case RayTraced::yes:
      return "yes";
    case RayTraced::no:
      return "no";
  }
  return "unknown";
}

bool is_translucent(const Material& material) {
  return sideray_material_is_translucent(&material.desc) != 0;
}

double degrees(float radians) {
  return double{radians} * 57.29577951308232;
}

// Rounds to six digits, so that a float does not print the digits of its double. std::stod() would throw for 1e-310.
double rounded(double value) {
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

template <typename T>
Json list(const T* values, size_t count) {
  Json json = Json::array();
  for (size_t i = 0; i < count; ++i) json.push_back(rounded(static_cast<double>(values[i])));
  return json;
}

struct Counts {
  size_t triangles = 0, lines = 0, points = 0, drawn_triangles = 0, translucent_objects = 0, texture_bytes = 0;
};

Counts count(const Content& content) {
  Counts counts;
  for (const Mesh& mesh : content.meshes) {
    if (mesh.topology == SIDERAY_LINES) counts.lines += mesh.indices.size() / 2;
    if (mesh.topology == SIDERAY_POINTS) counts.points += mesh.indices.size();
    if (mesh.topology == SIDERAY_TRIANGLES) counts.triangles += mesh.indices.size() / 3;
  }
  for (const Object& object : content.objects) {
    const Mesh& mesh = content.meshes[object.mesh];
    if (mesh.topology != SIDERAY_TRIANGLES) continue;
    counts.drawn_triangles += mesh.indices.size() / 3;
    if (is_translucent(content.materials[object.material])) ++counts.translucent_objects;
  }
  for (const Texture& texture : content.textures) counts.texture_bytes += texture.rgba.size();
  return counts;
}

Json counts_json(const Content& content) {
  const Counts counts = count(content);
  return {{"meshes", content.meshes.size()},
          {"triangles", counts.triangles},
          {"lines", counts.lines},
          {"points", counts.points},
          {"objects", content.objects.size()},
          {"drawn_triangles", counts.drawn_triangles},
          {"translucent_objects", counts.translucent_objects},
          {"materials", content.materials.size()},
          {"textures", content.textures.size()},
          {"texture_bytes", counts.texture_bytes}};
}

Json camera_json(const Camera& named) {
  const sideray_camera& camera = named.camera;
  Json json{{"name", named.name}, {"type", camera.orthographic != 0 ? "orthographic" : "perspective"}};
  if (camera.orthographic != 0)
    json["half_height"] = rounded(double{camera.half_height});
  else
    json["yfov_deg"] = rounded(degrees(camera.yfov));
  if (named.aspect > 0.0f) json["aspect"] = rounded(double{named.aspect});
  const double* m = camera.world_from_camera;
  const double forward[3] = {-m[6], -m[7], -m[8]};
  json["position"] = list(m + 9, 3);
  json["direction"] = list(forward, 3);
  json["z_near"] = rounded(double{camera.z_near});
  if (camera.z_far > 0.0f) json["z_far"] = rounded(double{camera.z_far});
  return json;
}

Json direction_json(const float direction[3]) {
  const double x = double{direction[0]}, y = double{direction[1]}, z = double{direction[2]};
  const double length = elementary::hypot(x, y, z);
  const double unit[3] = {x / length, y / length, z / length};
  return list(unit, 3);
}

Json light_json(const Light& named, size_t index) {
  const sideray_light& light = named.light;
  Json json{{"index", index}, {"name", named.name}, {"type", type_name(light.type)}};
  json["intensity"] = list(light.intensity, 3);
  if (light.type != SIDERAY_LIGHT_POINT) json["direction"] = direction_json(light.direction);
  if (light.type == SIDERAY_LIGHT_DIRECTIONAL) {
    json["angular_diameter_deg"] = rounded(double{light.angular_diameter_deg});
    return json;
  }
  json["position"] = list(light.position, 3);
  if (light.range > 0.0f) json["range"] = rounded(double{light.range});
  if (light.radius > 0.0f) json["radius"] = rounded(double{light.radius});
  if (light.type == SIDERAY_LIGHT_SPOT) {
    json["inner_cone_deg"] = rounded(degrees(light.inner_cone));
    json["outer_cone_deg"] = rounded(degrees(light.outer_cone));
  }
  return json;
}

bool any(const float color[3]) {
  return *std::max_element(color, color + 3) > 0.0f;
}

bool tints_specular(const sideray_material_desc& desc) {
  return desc.specular != 1.0f ||
         std::any_of(desc.specular_color, desc.specular_color + 3, [](float c) { return c != 1.0f; });
}

// Adds the lobes that few materials have, unless they do nothing.
void add_lobes(const sideray_material_desc& desc, Json& json) {
  if (any(desc.emissive)) json["emissive"] = list(desc.emissive, 3);
  if (tints_specular(desc)) {
    json["specular"] = rounded(double{desc.specular});
    json["specular_color"] = list(desc.specular_color, 3);
  }
  if (desc.clearcoat > 0.0f) {
    json["clearcoat"] = rounded(double{desc.clearcoat});
    json["clearcoat_roughness"] = rounded(double{desc.clearcoat_roughness});
  }
  if (any(desc.sheen_color)) {
    json["sheen_color"] = list(desc.sheen_color, 3);
    json["sheen_roughness"] = rounded(double{desc.sheen_roughness});
  }
  if (desc.diffuse_transmission > 0.0f) {
    json["diffuse_transmission"] = rounded(double{desc.diffuse_transmission});
    json["diffuse_transmission_color"] = list(desc.diffuse_transmission_color, 3);
  }
  if (desc.anisotropy > 0.0f) {
    json["anisotropy"] = rounded(double{desc.anisotropy});
    json["anisotropy_rotation"] = rounded(double{desc.anisotropy_rotation});
  }
  if (desc.iridescence > 0.0f) {
    json["iridescence"] = rounded(double{desc.iridescence});
    json["iridescence_ior"] = rounded(double{desc.iridescence_ior});
    json["iridescence_thickness_min"] = rounded(double{desc.iridescence_thickness_min});
    json["iridescence_thickness_max"] = rounded(double{desc.iridescence_thickness_max});
  }
}

Json material_json(const Content& content, size_t index) {
  const Material& material = content.materials[index];
  const sideray_material_desc& desc = material.desc;
  size_t objects = 0;
  for (const Object& object : content.objects) objects += object.material == index ? 1 : 0;
  Json textures = Json::object();
  for (const MaterialSlot& s : material_slots) {
    const uint32_t texture = (desc.*s.slot).texture;
    if (texture != 0) textures[s.name] = content.textures[texture - 1].name;
  }
  Json json{{"name", material.name},
            {"objects", objects},
            {"alpha_mode", mode_name(desc.alpha_mode)},
            {"translucent", is_translucent(material)},
            {"ray_traced", mark_name(material.ray_traced)},
            {"double_sided", desc.double_sided != 0},
            {"base_color", list(desc.base_color, 4)},
            {"metallic", rounded(double{desc.metallic})},
            {"roughness", rounded(double{desc.roughness})},
            {"transmission", rounded(double{desc.transmission})},
            {"ior", rounded(double{desc.ior})},
            {"thickness", rounded(double{desc.thickness})},
            {"textures", std::move(textures)}};
  if (desc.alpha_mode == SIDERAY_BLEND) json["blend"] = blend_name(desc.blend_mode);
  if (desc.unlit != 0) json["unlit"] = true;
  if (std::isfinite(desc.attenuation_distance)) {
    json["attenuation_distance"] = rounded(double{desc.attenuation_distance});
    json["attenuation_color"] = list(desc.attenuation_color, 3);
  }
  if (desc.dispersion > 0.0f) json["dispersion"] = rounded(double{desc.dispersion});
  add_lobes(desc, json);
  if (material.inexact_shadow) json["inexact_shadow"] = true;
  if (material.desc.distortion > 0.0f) json["distortion"] = rounded(double{material.desc.distortion});
  return json;
}

Json emitter_json(const Content& content, const Emitter& emitter) {
  const sideray_particles_desc& desc = emitter.particles.desc;
  Json json{{"name", emitter.node},
            {"count", emitter.particles.count},
            {"sprites", emitter.sprites.size()},
            {"blend", blend_name(desc.blend_mode)},
            {"lit", desc.lit != 0},
            {"soft_distance", rounded(double{desc.soft_distance})},
            {"cells", {desc.columns, desc.rows}}};
  if (emitter.texture != 0) json["texture"] = content.textures[emitter.texture - 1].name;
  return json;
}

std::string emitter_line(const Emitter& emitter) {
  const sideray_particles_desc& desc = emitter.particles.desc;
  std::string line = fmt::format("{}: up to {} sprites, {} now, {}, {}", emitter.node, emitter.particles.count,
                                 emitter.sprites.size(), blend_name(desc.blend_mode), desc.lit != 0 ? "lit" : "unlit");
  if (desc.columns * desc.rows > 1) line += fmt::format(", flip-book of {} by {}", desc.columns, desc.rows);
  if (desc.soft_distance > 0.0f) line += fmt::format(", soft over {:.3g}", desc.soft_distance);
  return line;
}

// Holds the translucent objects of one name, which --ray-traced patterns match.
struct NamedObjects {
  std::string name;
  bool by_auto = false;  // `auto` traces them
  size_t count = 0;
};

// Returns the names in the order of their first objects. Primitives of one node share its name but may differ in
// `by_auto`.
std::vector<NamedObjects> translucent_objects(const Content& content) {
  const std::vector<bool> traced = select_ray_traced(content, "auto", {}, 1, 1);
  std::vector<NamedObjects> groups;
  std::map<std::pair<std::string, bool>, size_t> group_of;
  for (size_t i = 0; i < content.objects.size(); ++i) {
    const Object& object = content.objects[i];
    const bool is_surface = content.meshes[object.mesh].topology == SIDERAY_TRIANGLES;
    if (!is_surface || !is_translucent(content.materials[object.material])) continue;
    const auto [found, added] = group_of.try_emplace({object.name, traced[i]}, groups.size());
    if (added) groups.push_back({object.name, traced[i], 0});
    ++groups[found->second].count;
  }
  return groups;
}

std::vector<std::string> object_lines(const Content& content) {
  std::vector<std::string> lines;
  for (const NamedObjects& group : translucent_objects(content)) {
    const std::string times = group.count > 1 ? fmt::format(" ({} objects)", group.count) : "";
    lines.push_back(
        fmt::format("{}{}: {}", group.name, times, group.by_auto ? "ray traced by auto" : "rasterized by auto"));
  }
  return lines;
}

std::string section(const char* title, std::vector<std::string> lines) {
  if (lines.empty()) return "";
  std::transform(lines.begin(), lines.end(), lines.begin(), printable);
  return fmt::format("{}\n  {}\n", title, fmt::join(lines, "\n  "));
}

std::vector<std::string> material_lines(const Content& content) {
  std::vector<std::string> lines;
  for (const Material& material : content.materials) {
    const sideray_material_desc& desc = material.desc;
    std::string line =
        fmt::format("{}: {}, roughness {:.3g}", material.name, mode_name(desc.alpha_mode), desc.roughness);
    if (desc.alpha_mode == SIDERAY_BLEND)
      line += fmt::format(", {} {:.3g}", blend_name(desc.blend_mode), desc.base_color[3]);
    if (desc.transmission > 0.0f) line += fmt::format(", transmission {:.3g}", desc.transmission);
    if (desc.unlit != 0) line += ", unlit";
    if (desc.metallic > 0.0f) line += fmt::format(", metallic {:.3g}", desc.metallic);
    if (desc.thickness > 0.0f) line += fmt::format(", thickness {:.3g}", desc.thickness);
    if (desc.clearcoat > 0.0f) line += fmt::format(", clearcoat {:.3g}", desc.clearcoat);
    if (any(desc.sheen_color)) line += fmt::format(", sheen");
    if (desc.diffuse_transmission > 0.0f)
      line += fmt::format(", diffuse transmission {:.3g}", desc.diffuse_transmission);
    if (desc.anisotropy > 0.0f) line += fmt::format(", anisotropy {:.3g}", desc.anisotropy);
    if (desc.iridescence > 0.0f) line += fmt::format(", iridescence {:.3g}", desc.iridescence);
    if (any(desc.emissive)) line += fmt::format(", emissive");
    if (desc.double_sided != 0) line += ", double-sided";
    if (material.ray_traced != RayTraced::by_default)
      line += fmt::format(", ray traced: {}", mark_name(material.ray_traced));
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

std::string info_json(const Content& content) {
  Json json{{"scene", content.name}, {"counts", counts_json(content)}};
  if (const Bounds bounds = bounds_of(content); !bounds.empty())
    json["bounds"] = {{"minimum", list(&bounds.minimum[0], 3)}, {"maximum", list(&bounds.maximum[0], 3)}};
  for (const char* key : {"cameras", "lights", "objects", "animations", "materials", "particles"})
    json[key] = Json::array();
  for (const Camera& camera : content.cameras) json["cameras"].push_back(camera_json(camera));
  for (size_t i = 0; i < content.lights.size(); ++i) json["lights"].push_back(light_json(content.lights[i], i));
  for (const NamedObjects& group : translucent_objects(content))
    json["objects"].push_back({{"name", group.name}, {"count", group.count}, {"auto", group.by_auto}});
  for (const Animation& animation : content.animations) {
    json["animations"].push_back({{"name", animation.name}, {"length_s", animation.length_s}});
  }
  json["variants"] = content.variants;
  for (size_t i = 0; i < content.materials.size(); ++i) json["materials"].push_back(material_json(content, i));
  for (const Emitter& emitter : content.emitters) json["particles"].push_back(emitter_json(content, emitter));
  json["extensions"] = content.extensions;
  json["defaulted"] = content.defaulted;
  json["warnings"] = content.warnings;
  // Names in a file may not be valid UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string info_text(const Content& content) {
  const Counts counts = count(content);
  std::string text = fmt::format(
      "{}\n  {} objects ({} translucent), {} triangles in {} meshes, {} as drawn, {} materials, {} textures\n",
      content.name, content.objects.size(), counts.translucent_objects, counts.triangles, content.meshes.size(),
      counts.drawn_triangles, content.materials.size(), content.textures.size());
  if (counts.lines + counts.points > 0) text += fmt::format("  {} lines, {} points\n", counts.lines, counts.points);
  if (const Bounds b = bounds_of(content); !b.empty()) {
    text += fmt::format("  from {:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g}\n", b.minimum.x, b.minimum.y, b.minimum.z,
                        b.maximum.x, b.maximum.y, b.maximum.z);
  }
  std::vector<std::string> cameras, lights, animations, emitters;
  for (const Emitter& emitter : content.emitters) emitters.push_back(emitter_line(emitter));
  for (const Animation& animation : content.animations)
    animations.push_back(fmt::format("{}: {:.4g} s", animation.name, animation.length_s));
  for (const Camera& camera : content.cameras) {
    cameras.push_back(
        camera.camera.orthographic != 0
            ? fmt::format("{}: orthographic, half height {:.4g}", camera.name, camera.camera.half_height)
            : fmt::format("{}: perspective, fov {:.4g} degrees", camera.name, degrees(camera.camera.yfov)));
  }
  for (const Light& light : content.lights) {
    const float* i = light.light.intensity;
    lights.push_back(
        fmt::format("{}: {}, {:.4g} {:.4g} {:.4g}", light.name, type_name(light.light.type), i[0], i[1], i[2]));
  }
  text += section("cameras", cameras) + section("lights", lights) +
          section("translucent objects", object_lines(content)) + section("materials", material_lines(content)) +
          section("variants of materials", content.variants);
  text +=
      section("particles", emitters) + section("animations", animations) + section("extensions", content.extensions);
  return text + section("defaulted", content.defaulted) + section("warnings", content.warnings);
}

}  // namespace sideray::scenes
