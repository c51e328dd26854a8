// Embree's device and scenes as owned objects: one scene per mesh, shared by the instances of top-level scenes. Seen by
// intersector.cpp only. One thread at a time; finished scenes may be traced by any.
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

// Throws Failure: INVALID_ARGUMENT for an unknown isa, UNSUPPORTED for one that the processor lacks. "" = best.
DeviceHandle open_device(const std::string& isa);
uint32_t native_packet_width(RTCDevice device);  // 16, 8, 4 or 1
// What the device runs on, as open_device calls it.
std::string isa_in_use(RTCDevice device, const std::string& pinned);
std::string embree_version(RTCDevice device);
// Turns Embree's pending error, if any, into a Failure.
void check_device(RTCDevice device, const char* doing);

// The triangles of one mesh in object space; scene is null where it has none. Reads the mesh's own vertices.
struct MeshScene {
  std::shared_ptr<const model::Mesh> mesh;
  SceneHandle scene;
  std::shared_ptr<const model::Mesh> neutral;  // whose triangles Embree reads, where the mesh moves
  uint64_t pose = 0;                           // as in PosedMesh; 0 = it is not one
  uint32_t version = 0;                        // grows when its vertices move
  uint32_t name = 0;                           // not a pose: the mesh's
  PoseQuality quality;                         // not a pose, and neutral is there
};
std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, std::shared_ptr<const model::Mesh> mesh);
std::shared_ptr<MeshScene> build_mesh_scene(RTCDevice device, const PosedMesh& posed);
// Refits or rebuilds; scenes of their own may move at once.
void move_mesh_scene(RTCDevice device, MeshScene& scene, const PosedMesh& posed);

// Shared with the scenes of the snapshot before, so that a mesh is built once.
using MeshScenes = std::unordered_map<const model::Mesh*, std::shared_ptr<MeshScene>>;

// Builds a scene of every mesh that the snapshot's instances have. A mesh that has the name and the triangles of one of
// the snapshot before is that one with other vertices. Poses and such meshes move on the update's executor.
MeshScenes build_meshes(RTCDevice device, const model::Snapshot& snapshot, const SceneUpdate& update,
                        const MeshScenes& before);

}  // namespace sideray::rt
