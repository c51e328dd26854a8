// Keeps a scene of instances across commits, and passes only changes to Embree. Only intersector.cpp and the benchmark
// see it. One thread at a time may call it; any thread may trace a committed scene.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/embree_scene.h"

namespace sideray::rt {

// Returns the bits of the kinds of rays that hit an instance, so that one scene serves several kinds.
using MaskOf = uint32_t (*)(const model::Material&, const model::Instance&);

class TopLevel {
 public:
  SceneHandle scene;       // geometry ids are indices of Snapshot::instances
  uint32_t mask_bits = 0;  // union of the instances' bits
  float magnitude = 0;     // largest coordinate in its arithmetic, in local units
  float origin_limit = 0;  // an origin farther out leaves Embree's range in the object space of some instance

  // Leaves out instances with mask 0 and those `culled` (1; missing = 0). `meshes` holds every mesh of the snapshot's
  // instances, and must outlive the scene or its next set_up(). Nothing may be traced until commit().
  void set_up(RTCDevice device, const model::Snapshot& snapshot, const MeshScenes& meshes,
              std::span<const uint8_t> culled, MaskOf mask_of);
  void commit(RTCDevice device);

  // Counts what the last set_up() changed.
  struct Changes {
    size_t attached = 0, changed = 0, detached = 0;
  };
  const Changes& changes() const { return changes_; }

 private:
  struct Entry {
    glm::mat4x3 transform{0.0f};
    GeometryHandle geometry;
    const MeshScene* mesh = nullptr;
    RTCScene mesh_scene = nullptr;
    uint32_t version = 0, mask = 0, wanted = 0;
    float reach = 0, limit = 0;
    double growth = 0;  // inverse_growth() of the transform without its translation
    bool attached = false, stale = false;
  };

  void look(Entry& entry, const model::Instance& instance, const MeshScene& mesh);
  void apply(RTCDevice device, Entry& entry, uint32_t id);
  void detach(Entry& entry, uint32_t id);

  std::vector<Entry> entries_;
  Changes changes_;
};

}  // namespace sideray::rt
