#include "rt/embree/raw_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "model/stopwatch.h"
#include "rt/base/float_mode.h"
#include "rt/base/view_rays.h"
#include "rt/embree/embree.h"
#include "rt/embree/embree_scene.h"
#include "rt/embree/top_level.h"

namespace sideray::rt {
namespace {

constexpr uint32_t block = 4;            // pixels a side that a packet covers
constexpr uint32_t blocks_in_piece = 8;  // a side, in the piece that a thread takes
constexpr float farthest_hit = 1e30f;
constexpr float farthest_vertex = 1e18f;  // Embree's own limit is 1.8e18

// Sprites have no triangles until they are turned toward a view.
bool is_traced(const model::Instance& instance) {
  return instance.sprites == 0;
}

uint64_t count_triangles(const model::Snapshot& snapshot) {
  uint64_t count = 0;
  for (const model::Instance& instance : snapshot.instances)
    if (is_traced(instance)) count += snapshot.meshes[instance.mesh]->triangles.size();
  return count;
}

SceneHandle new_scene(RTCDevice device) {
  SceneHandle scene(rtcNewScene(device));
  check_device(device, "adding the scene of a raw frame");
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
  return scene;
}

void commit(RTCDevice device, const SceneHandle& scene) {
  rtcCommitScene(scene.get());
  check_device(device, "building the scene of a raw frame");
}

// Adds a copy of the mesh's triangles, transformed by the instance. Leaves out those beyond Embree's range.
void add_triangles(RTCDevice device, RTCScene scene, const model::Mesh& mesh, const glm::mat4x3& place) {
  if (mesh.triangles.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  auto* const vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.positions.size()));
  auto* const triangles = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangles.size()));
  check_device(device, "adding a mesh of a raw frame");
  float reach = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    vertices[i] = place * glm::vec4(mesh.positions[i], 1.0f);
    for (int c = 0; c < 3; ++c) reach += std::abs(vertices[i][c]);
  }
  if (!(reach < farthest_vertex)) return;
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
  rtcSetGeometryMask(geometry.get(), 0xffffffffu);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene, geometry.get());
}

SceneHandle flat_scene(RTCDevice device, const model::Snapshot& snapshot) {
  SceneHandle scene = new_scene(device);
  for (const model::Instance& instance : snapshot.instances)
    if (is_traced(instance))
      add_triangles(device, scene.get(), *snapshot.meshes[instance.mesh], instance.local_from_object);
  commit(device, scene);
  return scene;
}

// Holds shared meshes and their instances, set up like the tracer's own scenes but with a better build quality.
struct InstancedScene {
  InstancedScene(RTCDevice device, const model::Snapshot& snapshot) {
    for (const model::Instance& instance : snapshot.instances) {
      std::shared_ptr<MeshScene>& entry = meshes[snapshot.meshes[instance.mesh].get()];
      if (!entry) entry = mesh_scene(device, snapshot.meshes[instance.mesh]);
    }
    top.scene = new_scene(device);
    top.set_up(device, snapshot, meshes, {}, [](const model::Material&, const model::Instance& instance) {
      return is_traced(instance) ? 1u : 0u;
    });
    top.commit(device);
  }

  static std::shared_ptr<MeshScene> mesh_scene(RTCDevice device, std::shared_ptr<const model::Mesh> mesh) {
    auto made = std::make_shared<MeshScene>();
    made->mesh = std::move(mesh);
    if (made->mesh->triangles.empty()) return made;
    made->scene = new_scene(device);
    add_triangles(device, made->scene.get(), *made->mesh, glm::mat4x3(1.0f));
    commit(device, made->scene);
    return made;
  }

  MeshScenes meshes;  // must outlive its instances
  TopLevel top;
};

// Makes the rays of pixels. Origin and unnormalized direction are linear in the pixel's position. Filling packets is
// part of the timed work, so it is cheap.
class PixelRays {
 public:
  PixelRays(const RawFrameRequest& request) {
    const ViewRays rays(request.view, request.width, request.height);
    const auto direction = [&](uint32_t x, uint32_t y) {
      const ViewRays::Pixel p = rays.pixel(x, y);
      return p.direction * (rays.perspective() ? static_cast<float>(p.length) : 1.0f);
    };
    const auto w = static_cast<float>(request.width), h = static_cast<float>(request.height);
    origin_ = {rays.pixel(0, 0).origin, (rays.pixel(request.width, 0).origin - rays.pixel(0, 0).origin) / w,
               (rays.pixel(0, request.height).origin - rays.pixel(0, 0).origin) / h};
    direction_ = {direction(0, 0), (direction(request.width, 0) - direction(0, 0)) / w,
                  (direction(0, request.height) - direction(0, 0)) / h};
  }

  bool traceable(float limit) const {
    const glm::vec3 o = glm::abs(origin_.first) + 16384.0f * (glm::abs(origin_.along_x) + glm::abs(origin_.along_y));
    return o.x <= limit && o.y <= limit && o.z <= limit;
  }

  void fill(uint32_t x0, uint32_t y0, RTCRayHit16& packet) const {
    RTCRay16& r = packet.ray;
    for (uint32_t i = 0; i < 16; ++i) {
      const auto x = static_cast<float>(static_cast<int>(x0 + i % block));
      const auto y = static_cast<float>(static_cast<int>(y0 + i / block));
      const auto at = [x, y](const Linear& l, int c) { return l.first[c] + x * l.along_x[c] + y * l.along_y[c]; };
      const float dx = at(direction_, 0), dy = at(direction_, 1), dz = at(direction_, 2);
      const float shorter = 1.0f / std::sqrt(dx * dx + dy * dy + dz * dz);
      r.org_x[i] = at(origin_, 0);
      r.org_y[i] = at(origin_, 1);
      r.org_z[i] = at(origin_, 2);
      r.dir_x[i] = dx * shorter;
      r.dir_y[i] = dy * shorter;
      r.dir_z[i] = dz * shorter;
      r.tnear[i] = 0.0f;
      r.tfar[i] = farthest_hit;
      r.time[i] = 0.0f;
      r.mask[i] = 0xffffffffu;
      r.id[i] = i;
      r.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
  }

 private:
  struct Linear {
    glm::vec3 first, along_x, along_y;
  };
  Linear origin_, direction_;
};

// Traces the whole frame once. Blocks at the picture's edges are traced whole; their distances have room.
class FrameTracer {
 public:
  FrameTracer(const RawFrameRequest& request, RTCScene scene)
      : rays_(request),
        scene_(scene),
        columns_((request.width + block - 1) / block),
        rows_((request.height + block - 1) / block),
        distances_(size_t{columns_} * rows_ * 16) {}

  bool traceable(float limit) const { return rays_.traceable(limit); }

  uint64_t hits() const {
    return static_cast<uint64_t>(
        std::count_if(distances_.begin(), distances_.end(), [](float d) { return d < farthest_hit; }));
  }

  void run(Executor& executor) {
    const size_t across = (columns_ + blocks_in_piece - 1) / blocks_in_piece;
    const size_t down = (rows_ + blocks_in_piece - 1) / blocks_in_piece;
    executor.run(across * down, [&](size_t i, uint32_t) {
      trace_piece(static_cast<uint32_t>(i % across) * blocks_in_piece,
                  static_cast<uint32_t>(i / across) * blocks_in_piece);
    });
  }

 private:
  void trace_piece(uint32_t first_column, uint32_t first_row) {
    alignas(64) static constexpr int all[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    alignas(64) RTCRayHit16 packet{};
    for (uint32_t row = first_row; row < std::min(first_row + blocks_in_piece, rows_); ++row)
      for (uint32_t column = first_column; column < std::min(first_column + blocks_in_piece, columns_); ++column) {
        rays_.fill(column * block, row * block, packet);
        embree::Query query;
        embree::IntersectArguments arguments(query, true, nullptr);
        embree::Packet<16>::intersect(all, scene_, arguments, &packet);
        std::copy_n(packet.ray.tfar, 16, distances_.data() + (size_t{row} * columns_ + column) * 16);
      }
  }

  PixelRays rays_;
  RTCScene scene_;
  uint32_t columns_, rows_;
  std::vector<float> distances_;
};

void time(const RawFrameRequest& request, RTCScene scene, float origin_limit, Executor& executor, RawFrame& result) {
  FrameTracer tracer(request, scene);
  if (!tracer.traceable(origin_limit)) return;
  tracer.run(executor);
  result.ms = std::numeric_limits<double>::infinity();
  for (uint32_t i = 0; i < std::max(request.repeats, 1u); ++i) {
    const Stopwatch watch;
    tracer.run(executor);
    result.ms = std::min(result.ms, watch.ms());
  }
  result.hits = tracer.hits();
}

}  // namespace

RawFrame time_raw_frame(const model::Snapshot& snapshot, const RawFrameRequest& request, const std::string& isa,
                        Executor& executor) {
  const FlushDenormals flush;
  const DeviceHandle device = open_device(isa);
  RawFrame result;
  result.triangles = count_triangles(snapshot);
  result.flat = result.triangles <= request.most_flat;
  if (result.flat) {
    SceneHandle scene;
    executor.inside([&] { scene = flat_scene(device.get(), snapshot); });
    time(request, scene.get(), farthest_vertex, executor, result);
  } else {
    std::unique_ptr<const InstancedScene> scene;
    executor.inside([&] { scene = std::make_unique<const InstancedScene>(device.get(), snapshot); });
    time(request, scene->top.scene.get(), scene->top.origin_limit, executor, result);
  }
  return result;
}

}  // namespace sideray::rt
