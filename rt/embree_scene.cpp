#include "rt/embree_scene.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "model/failure.h"

namespace sideray::rt {
namespace {

#if defined(__x86_64__) || defined(__i386__)
struct InstructionSet {
  std::string_view name;
  bool (*supported)();
};

// Best first.
constexpr std::array<InstructionSet, 5> instruction_sets{{
    {"avx512",
     [] {
       return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("avx512vl");
     }},
    {"avx2", [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
    {"avx", [] { return __builtin_cpu_supports("avx") != 0; }},
    {"sse4.2", [] { return __builtin_cpu_supports("sse4.2") != 0; }},
    {"sse2", [] { return __builtin_cpu_supports("sse2") != 0; }},
}};

void check_isa(const std::string& isa) {
  for (const InstructionSet& set : instruction_sets) {
    if (set.name != isa) continue;
    if (!set.supported())
      fail(SIDERAY_UNSUPPORTED, "instruction set \"{}\": this processor lacks it; leave it empty for the best", isa);
    return;
  }
  std::array<std::string_view, instruction_sets.size()> names;
  std::transform(instruction_sets.begin(), instruction_sets.end(), names.begin(),
                 [](const InstructionSet& set) { return set.name; });
  fail(SIDERAY_INVALID_ARGUMENT, "instruction set \"{}\": unknown; accepted are {}", isa, fmt::join(names, ", "));
}
#else
void check_isa(const std::string& isa) {
  fail(SIDERAY_UNSUPPORTED, "instruction set \"{}\": none can be chosen on this processor; leave it empty", isa);
}
#endif

bool has_property(RTCDevice device, RTCDeviceProperty property) {
  return rtcGetDeviceProperty(device, property) != 0;
}

sideray_status status_of(RTCError error) {
  switch (error) {
    case RTC_ERROR_OUT_OF_MEMORY:
      return SIDERAY_OUT_OF_MEMORY;
    case RTC_ERROR_UNSUPPORTED_CPU:
      return SIDERAY_UNSUPPORTED;
    default:
      return SIDERAY_INTERNAL;
  }
}

const char* text_of(RTCError error) {
  switch (error) {
    case RTC_ERROR_OUT_OF_MEMORY:
      return "out of memory; use fewer or smaller meshes";
    case RTC_ERROR_UNSUPPORTED_CPU:
      return "it does not run on this processor";
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case RTC_ERROR_INVALID_OPERATION:
      return "invalid operation";
    case RTC_ERROR_CANCELLED:
      return "cancelled";
    default:
      return "unknown error";
  }
}

// Embree reads 16 bytes at the last vertex: shared where the vector's own memory reaches that far, else copied.
void set_vertices(RTCGeometry geometry, const model::Mesh& mesh) {
  constexpr size_t stride = sizeof(glm::vec3);
  static_assert(stride == 12);
  if (mesh.positions.capacity() > mesh.positions.size()) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0, stride,
                               mesh.positions.size());
    return;
  }
  void* copy =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, stride, mesh.positions.size());
  if (copy) std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<glm::vec3*>(copy));
}

glm::vec3 largest_corner(const model::Bounds& b) {
  return glm::max(glm::abs(b.minimum), glm::abs(b.maximum));
}

float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// Largest length that a unit vector of local space gets in object space, and at least 1.
double inverse_growth(const glm::mat4x3& m) {
  // Embree inverts in floats: a determinant out of their range makes NaN of every ray.
  const float determinant = glm::determinant(glm::mat3(m[0], m[1], m[2]));
  if (!std::isnormal(determinant)) return std::numeric_limits<double>::infinity();
  const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::dvec3(m[0]), glm::dvec3(m[1]), glm::dvec3(m[2])));
  double sum = 1.0;
  for (int c = 0; c < 3; ++c) sum = std::max(sum, glm::length(inverse[c]) * 3.0);
  return sum;
}

// Embree's own limit is 1.8e18, holds in every object's space, and is asserted there.
constexpr double largest_coordinate = 1e18;

// How far from the local origin a ray may start so that it stays in range in the instance's object space.
double origin_limit(const model::Instance& instance) {
  const glm::mat4x3& m = instance.local_from_object;
  return largest_coordinate / inverse_growth(m) - 3.0 * static_cast<double>(largest_component(m[3]));
}

// The largest local coordinate that enters the instance's arithmetic.
float reach(const model::Instance& instance, const model::Mesh& mesh) {
  const glm::mat4x3& m = instance.local_from_object;
  const glm::mat3 absolute(glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2]));
  return largest_component(absolute * largest_corner(mesh.bounds) + glm::abs(m[3]));
}

void attach_instance(RTCDevice device, RTCScene scene, RTCScene mesh, const glm::mat4x3& transform, uint32_t mask,
                     uint32_t id) {
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  if (!geometry) return;
  rtcSetGeometryInstancedScene(geometry.get(), mesh);
  static_assert(sizeof(transform) == 12 * sizeof(float));
  rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &transform[0][0]);
  rtcSetGeometryMask(geometry.get(), mask);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), id);
}

}  // namespace

DeviceHandle open_device(const std::string& isa) {
  if (!isa.empty()) check_isa(isa);
  // Not `threads`: Embree would limit TBB in the whole process. Builds stay in the arena that commits them.
  const std::string config = isa.empty() ? "" : "isa=" + isa;
  DeviceHandle device(rtcNewDevice(config.c_str()));
  if (!device) {
    const RTCError error = rtcGetDeviceError(nullptr);
    fail(status_of(error), "ray tracing: Embree gave no device: {}", text_of(error));
  }
  check_device(device.get(), "opening the device");
  if (!has_property(device.get(), RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) ||
      !has_property(device.get(), RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED))
    fail(SIDERAY_UNSUPPORTED, "ray tracing: this Embree is built without {}; use one that has both",
         "ray masks or filters");
  return device;
}

uint32_t native_packet_width(RTCDevice device) {
  if (has_property(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  if (has_property(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
  if (has_property(device, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED)) return 4;
  return 1;
}

std::string isa_in_use(RTCDevice device, const std::string& pinned) {
  if (!pinned.empty()) return pinned;
#if defined(__x86_64__) || defined(__i386__)
  const uint32_t width = native_packet_width(device);
  for (const InstructionSet& set : instruction_sets) {
    const uint32_t set_width = set.name == "avx512" ? 16 : (set.name.starts_with("avx") ? 8 : 4);
    if (set_width <= width && set.supported()) return std::string(set.name);
  }
#endif
  return fmt::format("native{}", native_packet_width(device));
}

std::string embree_version(RTCDevice device) {
  const auto property = [device](RTCDeviceProperty p) { return rtcGetDeviceProperty(device, p); };
  return fmt::format("{}.{}.{}", property(RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                     property(RTC_DEVICE_PROPERTY_VERSION_MINOR), property(RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

void check_device(RTCDevice device, const char* doing) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    fail(status_of(error), "ray tracing: {}: Embree says {}", doing, text_of(error));
}

MeshScene build_mesh_scene(RTCDevice device, std::shared_ptr<const model::Mesh> mesh) {
  MeshScene result{std::move(mesh), nullptr};
  const model::Mesh& m = *result.mesh;
  if (m.triangles.empty()) return result;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  SceneHandle scene(rtcNewScene(device));
  check_device(device, "adding a mesh");
  set_vertices(geometry.get(), m);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m.triangles.data(), 0,
                             sizeof(glm::uvec3), m.triangles.size());
  rtcSetGeometryMask(geometry.get(), 0xffffffffu);
  check_device(device, "adding a mesh");
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), 0);
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | embree::filter_flag));
  rtcCommitScene(scene.get());
  check_device(device, "building a mesh");
  result.scene = std::move(scene);
  return result;
}

TopLevel build_top_level(RTCDevice device, const model::Snapshot& snapshot, const MeshScenes& meshes, MaskOf mask_of) {
  TopLevel top;
  top.scene.reset(rtcNewScene(device));
  check_device(device, "adding a scene");
  rtcSetSceneFlags(top.scene.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | embree::filter_flag));
  std::vector<uint32_t> masks(snapshot.instances.size());
  for (size_t i = 0; i < masks.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
    const float instance_reach = reach(instance, mesh);
    if (!meshes.at(&mesh)->scene || !std::isfinite(instance_reach)) continue;
    masks[i] = mask_of(snapshot.materials[instance.material], instance);
    if (masks[i] != 0) top.magnitude = std::max(top.magnitude, instance_reach);
  }
  // An instance is left out that is so flat or small beside the others that no ray from among them is in its range.
  const double least_limit = 1e3 * static_cast<double>(top.magnitude);
  double limit = largest_coordinate;
  for (size_t i = 0; i < masks.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    const double instance_limit = masks[i] == 0 ? 0.0 : origin_limit(instance);
    if (!(instance_limit > least_limit)) continue;
    const MeshScene& mesh = *meshes.at(snapshot.meshes[instance.mesh].get());
    attach_instance(device, top.scene.get(), mesh.scene.get(), instance.local_from_object, masks[i],
                    static_cast<uint32_t>(i));
    limit = std::min(limit, instance_limit);
    top.mask_bits |= masks[i];
  }
  rtcCommitScene(top.scene.get());
  check_device(device, "building the scene");
  top.origin_limit = static_cast<float>(limit);
  return top;
}

}  // namespace sideray::rt
