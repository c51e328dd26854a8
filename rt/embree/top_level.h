// Keeps a scene of instances from commit to commit, and changes in Embree only what differs. Only intersector.cpp and the
// benchmark see it. One thread at a time may call it; any thread may trace a committed scene.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/embree_scene.h"

namespace sideray::rt {

// Returns which rays hit an instance, as bits of their own, so that one scene serves several kinds of rays.
using MaskOf = uint32_t (*)(const model::Material&, const model::Instance&);

class TopLevel {
 public:
  SceneHandle scene;       // geometry ids are indices of Snapshot::instances
  uint32_t mask_bits = 0;  // all bits that some instance has
  float magnitude = 0;     // largest coordinate that enters its arithmetic, in local units
  float origin_limit = 0;  // an origin farther out would leave Embree's range in some object's space

  // Leaves out instances with mask 0 and those `culled` (1; missing = 0). `meshes` holds every mesh of the snapshot's
  // instances and outlives the scene or its next set-up. Until commit() nothing may be traced.
  void set_up(RTCDevice device, const model::Snapshot& snapshot, const MeshScenes& meshes,
              std::span<const uint8_t> culled, MaskOf mask_of);
  void commit(RTCDevice device);

  // Counts what the last set-up changed.
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
    double growth = 0;  // that of the transform without its translation
    bool attached = false, stale = false;
  };

  void look(Entry& entry, const model::Instance& instance, const MeshScene& mesh);
  void apply(RTCDevice device, Entry& entry, uint32_t id);
  void detach(Entry& entry, uint32_t id);

  std::vector<Entry> entries_;
  Changes changes_;
};

}  // namespace sideray::rt
