#include "rt/embree/embree_scene.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "model/failure.h"
#include "model/mesh.h"
#include "rt/base/executor.h"

namespace sideray::rt {
namespace {

#if defined(__x86_64__) || defined(__i386__)
struct InstructionSet {
  std::string_view name;
  bool (*supported)();
};

// In order of preference, the best first.
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
      return "it does not run on this processor; use another machine";
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument; please report this";
    case RTC_ERROR_INVALID_OPERATION:
      return "invalid operation; please report this";
    case RTC_ERROR_CANCELLED:
      return "cancelled; try again";
    default:
      return "unknown error, as where memory is out; close other programs or ask for less";
  }
}

// Embree reads 16 bytes at the last vertex, 4 more than it has. The mesh's memory is shared if it reaches that far, and
// copied otherwise.
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

// `topology` has the same triangles as `mesh`; if the mesh `moves`, it must outlive the scene.
SceneHandle scene_of(RTCDevice device, const model::Mesh& mesh, const model::Mesh& topology, bool moves) {
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  SceneHandle scene(rtcNewScene(device));
  check_device(device, "adding a mesh");
  set_vertices(geometry.get(), mesh);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, topology.triangles.data(), 0,
                             sizeof(glm::uvec3), topology.triangles.size());
  rtcSetGeometryMask(geometry.get(), 0xffffffffu);
  if (moves) rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_REFIT);
  check_device(device, "adding a mesh");
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), 0);
  const int flags = RTC_SCENE_FLAG_ROBUST | embree::filter_flag | (moves ? RTC_SCENE_FLAG_DYNAMIC : 0);
  // Only a geometry with its own tree can be refit, and Embree gives it one only at the scene's lowest build quality.
  // The geometry's own tree is still built with the surface area heuristic.
  if (moves) rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_LOW);
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(flags));
  rtcCommitScene(scene.get());
  check_device(device, "building a mesh");
  return scene;
}

}  // namespace

DeviceHandle open_device(const std::string& isa) {
  if (!isa.empty()) check_isa(isa);
  // `threads` is not set: Embree would limit TBB in the whole process. Builds stay in the arena that commits them.
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

std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, std::shared_ptr<const model::Mesh> mesh) {
  auto result = std::make_shared<MeshScene>();
  result->mesh = std::move(mesh);
  if (!result->mesh->triangles.empty()) result->scene = scene_of(device, *result->mesh, *result->mesh, false);
  return result;
}

std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, const PosedMesh& posed) {
  auto result = std::make_shared<MeshScene>();
  result->mesh = posed.mesh;
  result->neutral = posed.neutral;
  result->pose = posed.pose;
  if (!posed.mesh->triangles.empty()) result->scene = scene_of(device, *posed.mesh, *posed.neutral, true);
  return result;
}

void move_mesh_scene(RTCDevice device, MeshScene& scene, const PosedMesh& posed) {
  scene.mesh = posed.mesh;
  if (posed.change == PoseChange::none || !scene.scene) return;
  const RTCGeometry geometry = rtcGetGeometry(scene.scene.get(), 0);
  set_vertices(geometry, *posed.mesh);
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  // Embree refits as long as only vertices change; a change of the indices makes it rebuild.
  if (posed.change == PoseChange::rebuild) rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene.scene.get());
  check_device(device, "moving a mesh");
  ++scene.version;
}

namespace {

void run(Executor* executor, size_t count, const std::function<void(size_t)>& work) {
  if (executor)
    executor->run(count, [&](size_t i, uint32_t) { work(i); });
  else
    for (size_t i = 0; i < count; ++i) work(i);
}

// Builds or refits the scenes of poses. Each is one piece of work, whose result does not depend on the thread.
void take_poses(RTCDevice device, const SceneUpdate& update, const MeshScenes& before, MeshScenes& meshes) {
  if (update.posed.empty()) return;
  std::unordered_map<uint64_t, std::shared_ptr<MeshScene>> known;
  for (const auto& [mesh, scene] : before)
    if (scene->pose != 0) known.emplace(scene->pose, scene);
  std::vector<std::shared_ptr<MeshScene>> scenes(update.posed.size());
  run(update.executor, scenes.size(), [&](size_t i) {
    const PosedMesh& posed = update.posed[i];
    const auto found = known.find(posed.pose);
    if (found == known.end()) {
      scenes[i] = build_mesh_scene(device, posed);
    } else {
      scenes[i] = found->second;
      move_mesh_scene(device, *scenes[i], posed);
    }
  });
  for (size_t i = 0; i < scenes.size(); ++i) meshes[update.posed[i].mesh.get()] = scenes[i];
}

// Returns the scene of a mesh with changed vertices. The first time, the scene is rebuilt so that it can be refit;
// afterwards it is refit, or rebuilt if its quality has become too low.
std::shared_ptr<MeshScene> with_vertices(RTCDevice device, const std::shared_ptr<MeshScene>& before,
                                         const std::shared_ptr<const model::Mesh>& mesh) {
  if (!before->neutral) {
    std::shared_ptr<MeshScene> scene = build_mesh_scene(device, PosedMesh{mesh, mesh, 0, PoseChange::rebuild});
    scene->quality.build(*mesh);
    return scene;
  }
  const bool serves = before->quality.growth(*mesh) < PoseQuality::worst_growth;
  move_mesh_scene(device, *before, {before->neutral, mesh, 0, serves ? PoseChange::refit : PoseChange::rebuild});
  if (!serves) before->quality.build(*mesh);
  return before;
}

// Returns the scenes of meshes that are no longer in the snapshot, by mesh name. A new mesh of the same name and
// triangles may reuse one.
std::unordered_map<uint32_t, std::shared_ptr<MeshScene>> left_behind(const model::Snapshot& snapshot,
                                                                     const MeshScenes& before) {
  std::unordered_set<const model::Mesh*> present;
  for (const std::shared_ptr<const model::Mesh>& mesh : snapshot.meshes) present.insert(mesh.get());
  std::unordered_map<uint32_t, std::shared_ptr<MeshScene>> left;
  for (const auto& [mesh, scene] : before)
    if (scene->pose == 0 && scene->scene && !present.contains(mesh)) left.emplace(scene->name, scene);
  return left;
}

}  // namespace

MeshScenes build_meshes(RTCDevice device, const model::Snapshot& snapshot, const SceneUpdate& update,
                        const MeshScenes& before) {
  MeshScenes meshes;
  take_poses(device, update, before, meshes);
  const auto left = left_behind(snapshot, before);
  struct Moved {
    uint32_t index;
    std::shared_ptr<MeshScene> scene;
  };
  std::vector<Moved> moved;
  std::vector<bool> seen(snapshot.meshes.size());
  for (const model::Instance& instance : snapshot.instances) {
    if (seen[instance.mesh]) continue;
    seen[instance.mesh] = true;
    const std::shared_ptr<const model::Mesh>& mesh = snapshot.meshes[instance.mesh];
    const uint32_t name = snapshot.mesh_names[instance.mesh].name;
    std::shared_ptr<MeshScene>& entry = meshes[mesh.get()];
    if (entry) continue;
    if (const auto known = before.find(mesh.get()); known != before.end()) {
      entry = known->second;
    } else if (const auto other = left.find(name);
               other != left.end() && model::same_triangles(*other->second->mesh, *mesh)) {
      moved.push_back({instance.mesh, other->second});
      continue;
    } else {
      entry = build_mesh_scene(device, mesh);
    }
    entry->name = name;
  }
  run(update.executor, moved.size(), [&](size_t i) {
    moved[i].scene = with_vertices(device, moved[i].scene, snapshot.meshes[moved[i].index]);
    moved[i].scene->name = snapshot.mesh_names[moved[i].index].name;
  });
  for (const Moved& m : moved) meshes[snapshot.meshes[m.index].get()] = m.scene;
  return meshes;
}

}  // namespace sideray::rt
