#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {
namespace {

void refuse_unless_below(const File& file, std::span<const uint32_t> indices, size_t vertices,
                         const std::string& name) {
  for (const uint32_t index : indices) {
    if (index >= vertices) {
      refuse("cannot read {}: mesh {} uses vertex {}, and there are {}; export it again", file.path, name, index,
             vertices);
    }
  }
}

// Returns the corners of lists, strips and fans as separate triangles of the same winding (glTF 2.0, 3.7.2.1).
std::vector<uint32_t> triangle_list(const std::vector<uint32_t>& corners, int mode) {
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    return {corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(corners.size() / 3 * 3)};
  }
  if (corners.size() < 3) return {};
  std::vector<uint32_t> triangles;
  triangles.reserve(3 * (corners.size() - 2));
  for (size_t i = 0; i + 2 < corners.size(); ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      triangles.insert(triangles.end(), {corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    } else {
      triangles.insert(triangles.end(), {corners[i + 1], corners[i + 2], corners[0]});
    }
  }
  return triangles;
}

// Returns the corners of lists, strips and loops as separate lines.
std::vector<uint32_t> line_list(const std::vector<uint32_t>& corners, int mode) {
  if (mode == TINYGLTF_MODE_LINE)
    return {corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(corners.size() / 2 * 2)};
  std::vector<uint32_t> lines;
  if (corners.size() < 2) return lines;
  lines.reserve(2 * corners.size());
  for (size_t i = 0; i + 1 < corners.size(); ++i) lines.insert(lines.end(), {corners[i], corners[i + 1]});
  if (mode == TINYGLTF_MODE_LINE_LOOP) lines.insert(lines.end(), {corners.back(), corners.front()});
  return lines;
}

// Returns an upper bound on the indices that `corners` corners become.
size_t most_indices(size_t corners, int mode) {
  return mode == TINYGLTF_MODE_TRIANGLES ? corners : 3 * corners;
}

struct Primitives {
  const char* name;
  size_t corners;  // of each primitive
};
Primitives primitives_of(sideray_topology topology) {
  if (topology == SIDERAY_POINTS) return {"points", 1};
  if (topology == SIDERAY_LINES) return {"lines", 2};
  return {"triangles", 3};
}

sideray_topology topology_of(int mode) {
  if (mode == TINYGLTF_MODE_POINTS) return SIDERAY_POINTS;
  return mode < TINYGLTF_MODE_TRIANGLES ? SIDERAY_LINES : SIDERAY_TRIANGLES;
}

std::vector<uint32_t> primitive_list(const std::vector<uint32_t>& corners, int mode) {
  if (mode == TINYGLTF_MODE_POINTS) return corners;
  return mode < TINYGLTF_MODE_TRIANGLES ? line_list(corners, mode) : triangle_list(corners, mode);
}

bool usable_position(const float* p) {
  return std::all_of(p, p + 3, [](float x) { return std::abs(x) <= static_cast<float>(limits::coordinate); });
}

// Removes primitives at positions that no renderer can draw, and moves their vertices to the origin.
void drop_broken_primitives(Mesh& mesh, Content& content) {
  const auto [name, corners] = primitives_of(mesh.topology);
  std::vector<uint32_t> kept;
  kept.reserve(mesh.indices.size());
  for (auto first = mesh.indices.begin(); first != mesh.indices.end();) {
    const auto end = first + static_cast<std::ptrdiff_t>(corners);
    if (std::all_of(first, end, [&](uint32_t v) { return usable_position(&mesh.positions[3 * size_t{v}]); }))
      kept.insert(kept.end(), first, end);
    first = end;
  }
  if (kept.size() != mesh.indices.size()) {
    content.warnings.push_back(fmt::format("mesh {}: {} of {} {} have positions that are not finite; left out",
                                           mesh.name, (mesh.indices.size() - kept.size()) / corners,
                                           mesh.indices.size() / corners, name));
    mesh.indices = std::move(kept);
  }
  for (size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
    if (!usable_position(&mesh.positions[i])) std::fill_n(&mesh.positions[i], 3, 0.0f);
  }
}

void warn_not_finite(const std::vector<float>& values, const char* attribute, const Mesh& mesh, Content& content) {
  const auto count = std::count_if(values.begin(), values.end(), [](float x) { return !std::isfinite(x); });
  if (count > 0) {
    content.warnings.push_back(
        fmt::format("mesh {}: {} numbers of {} are not finite; defaults are used there", mesh.name, count, attribute));
  }
}

std::vector<float> read_colors(const File& file, int accessor, size_t vertices, const std::string& user) {
  if (accessor_components(file, accessor, user) == 4) return read_floats(file, accessor, 4, vertices, user);
  const std::vector<float> rgb = read_floats(file, accessor, 3, vertices, user);
  file.budget.take(vertices * 4 * sizeof(float), user);
  std::vector<float> rgba(vertices * 4, 1.0f);
  for (size_t i = 0; i < vertices; ++i) std::copy_n(&rgb[3 * i], 3, &rgba[4 * i]);
  return rgba;
}

void read_attributes(const File& file, const tinygltf::Primitive& primitive, size_t vertices, Mesh& mesh,
                     Content& content) {
  struct Wanted {
    const char* attribute;
    uint32_t components;
    std::vector<float>& values;
  };
  const Wanted wanted[] = {{"NORMAL", 3, mesh.normals},
                           {"TANGENT", 4, mesh.tangents},
                           {"TEXCOORD_0", 2, mesh.uv0},
                           {"TEXCOORD_1", 2, mesh.uv1},
                           {"COLOR_0", 0, mesh.colors}};
  for (const Wanted& want : wanted) {
    const auto found = primitive.attributes.find(want.attribute);
    if (found == primitive.attributes.end()) continue;
    const std::string user = fmt::format("mesh {}, {}", mesh.name, want.attribute);
    want.values = want.components == 0 ? read_colors(file, found->second, vertices, user)
                                       : read_floats(file, found->second, want.components, vertices, user);
    warn_not_finite(want.values, want.attribute, mesh, content);
  }
  // Tangents without normals are ignored (glTF 2.0, 3.7.2.1).
  if (mesh.normals.empty()) mesh.tangents.clear();
}

// Returns whether the primitive's material needs tangents that the mesh neither has nor gets from uvs.
bool lacks_direction(const File& file, const tinygltf::Primitive& primitive, const Mesh& mesh) {
  if (!mesh.tangents.empty() || !mesh.uv0.empty()) return false;
  const std::vector<tinygltf::Material>& materials = file.model.materials;
  return primitive.material >= 0 && static_cast<size_t>(primitive.material) < materials.size() &&
         materials[static_cast<size_t>(primitive.material)].extensions.contains("KHR_materials_anisotropy");
}

void warn_of_translucency(const File& file, const tinygltf::Primitive& primitive, const Mesh& mesh, Content& content) {
  const auto index = static_cast<size_t>(primitive.material);
  if (primitive.material < 0 || index >= file.model.materials.size()) return;
  const tinygltf::Material& material = file.model.materials[index];
  if (material.alphaMode != "BLEND" && !material.extensions.contains("KHR_materials_transmission")) return;
  content.warnings.push_back(fmt::format("mesh {}: its material is translucent, and its {} are drawn opaque", mesh.name,
                                         primitives_of(mesh.topology).name));
}

}  // namespace

Mesh read_primitive(const File& file, const tinygltf::Primitive& primitive, const std::string& name, Content& content) {
  Mesh mesh;
  mesh.name = name;
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    content.warnings.push_back(fmt::format("mesh {}: its mode {} is unknown; left out", name, mode));
    return mesh;
  }
  mesh.topology = topology_of(mode);
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) {
    content.warnings.push_back(fmt::format("mesh {}: it has no vertices; left out", name));
    return mesh;
  }
  mesh.positions = read_floats(file, position->second, 3, 0, fmt::format("mesh {}, POSITION", name));
  const size_t vertices = mesh.positions.size() / 3;
  std::vector<uint32_t> corners;
  if (primitive.indices >= 0) {
    corners = read_unsigned(file, primitive.indices, fmt::format("mesh {}, indices", name));
    refuse_unless_below(file, corners, vertices, name);
  } else {
    corners.resize(vertices);
    for (size_t i = 0; i < vertices; ++i) corners[i] = static_cast<uint32_t>(i);
  }
  file.budget.take(most_indices(corners.size(), mode) * sizeof(uint32_t),
                   fmt::format("mesh {}, {}", name, primitives_of(mesh.topology).name));
  mesh.indices = primitive_list(corners, mode);
  read_attributes(file, primitive, vertices, mesh, content);
  drop_broken_primitives(mesh, content);
  if (mesh.topology != SIDERAY_TRIANGLES)
    warn_of_translucency(file, primitive, mesh, content);
  else if (lacks_direction(file, primitive, mesh))
    content.warnings.push_back(
        fmt::format("mesh {}: its material is anisotropic, and it has neither TANGENT nor TEXCOORD_0 that say which "
                    "way; it is drawn without",
                    name));
  if (mesh.indices.empty()) content.warnings.push_back(fmt::format("mesh {}: it has no {}; left out", name,
                                                                    primitives_of(mesh.topology).name));
  return mesh;
}

}  // namespace sideray::scenes::gltf
