// Owns Embree's device and scenes: one scene per mesh, shared by the instances of top-level scenes. Only
// intersector.cpp sees it. One thread at a time may call it; any thread may trace a finished scene.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "model/snapshot.h"
#include "rt/embree/embree.h"
#include "rt/embree/scene_update.h"
#include "rt/poses/pose_quality.h"

namespace sideray::rt {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct ReleaseGeometry {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;
using GeometryHandle = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseGeometry>;

// Opens a device for an instruction set; "" = the best. Throws Failure: INVALID_ARGUMENT for an unknown isa,
// UNSUPPORTED for one that the processor lacks.
DeviceHandle open_device(const std::string& isa);
uint32_t native_packet_width(RTCDevice device);  // 16, 8, 4 or 1
// Returns the instruction set that the device runs on, as open_device() names it.
std::string isa_in_use(RTCDevice device, const std::string& pinned);
std::string embree_version(RTCDevice device);
// Turns Embree's pending error, if any, into a Failure.
void check_device(RTCDevice device, const char* doing);

// Holds the triangles of one mesh in object space; `scene` is null if the mesh has none. Embree reads the vertices from
// the mesh itself.
struct MeshScene {
  std::shared_ptr<const model::Mesh> mesh;
  SceneHandle scene;
  std::shared_ptr<const model::Mesh> neutral;  // the mesh whose triangles Embree reads, if vertices change
  uint64_t pose = 0;                           // as in PosedMesh; 0 = not a pose
  uint32_t version = 0;                        // grows when the mesh's vertices move
  uint32_t name = 0;                           // the mesh's name; unset for poses
  PoseQuality quality;                         // of the tree; used where `neutral` is set and this is not a pose
};
std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, std::shared_ptr<const model::Mesh> mesh);
std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, const PosedMesh& posed);
// Refits or rebuilds a scene. Different scenes may be moved at the same time.
void move_mesh_scene(RTCDevice device, MeshScene& scene, const PosedMesh& posed);

// Unchanged meshes share their scenes with the previous snapshot, so that each is built once.
using MeshScenes = std::unordered_map<const model::Mesh*, std::shared_ptr<MeshScene>>;

// Returns a scene for every mesh that the snapshot's instances use. A mesh that has the name and triangles of a mesh of
// the previous snapshot, but other vertices, takes over its scene. Such meshes and poses are refit on the update's
// executor.
MeshScenes build_meshes(RTCDevice device, const model::Snapshot& snapshot, const SceneUpdate& update,
                        const MeshScenes& before);

}  // namespace sideray::rt
