#include "rt/intersector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "rt/embree.h"
#include "rt/embree_scene.h"
#include "rt/layer_collector.h"
#include "rt/recompute.h"
#include "rt/trace_table.h"

namespace sideray::rt {
namespace {

constexpr uint32_t most_lanes = 16, most_layers = 64;

// Instance masks of the two top-level scenes.
enum : uint32_t { mask_in_layers = 1, mask_translucent = 2 };
enum : uint32_t { mask_reflection = 1, mask_shadow = 2, mask_ao = 4 };

uint32_t layers_mask(const model::Material& material, const model::Instance& instance) {
  if (!material.translucent) return 0;
  const bool in_layers =
      material.traceable && (instance.visibility & SIDERAY_VISIBLE_LAYERS) && instance.surface_id != 0;
  return mask_translucent | (in_layers ? mask_in_layers : 0u);
}

uint32_t world_mask(const model::Material& material, const model::Instance& instance) {
  if (material.translucent) return 0;
  return ((instance.visibility & SIDERAY_VISIBLE_REFLECTION) ? mask_reflection : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_SHADOW) ? mask_shadow : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_AO) ? mask_ao : 0u);
}

uint32_t mask_of(LayerSet set) {
  return set == LayerSet::visible_in_layers ? mask_in_layers : mask_translucent;
}

// Embree asks for flush-to-zero in the calling thread: denormals cost a hundredfold.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : saved_(_mm_getcsr()) {
    _mm_setcsr(saved_ | 0x8040u);
  }
  ~FlushDenormals() {
    _mm_setcsr(saved_);
  }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_;
#else
  FlushDenormals() {}
#endif
};

inline float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// A power of two that brings a very long or very short direction to Embree's liking; 1 for ordinary ones.
float direction_scale(float size) {
  if (size > 0x1p-10f && size < 0x1p10f) return 1.0f;
  return std::ldexp(1.0f, std::clamp(-std::ilogb(size), -126, 126));
}

template <unsigned N>
class RayPacket {
 public:
  using Types = embree::Packet<N>;

  explicit RayPacket(uint32_t mask) {
    for (uint32_t i = 0; i < N; ++i) {
      RTCRayN_time(ray_n(), N, i) = 0.0f;
      RTCRayN_mask(ray_n(), N, i) = mask;
      RTCRayN_id(ray_n(), N, i) = i;
      RTCRayN_flags(ray_n(), N, i) = 0;
    }
  }

  // `widen`: lets Embree name everything that may, within its rounding, lie between the ray's ends. False where the ray
  // is not one, and the lane was cleared.
  bool set(uint32_t lane, const Ray& ray, const TopLevel& top, bool widen) {
    const float reach = largest_component(ray.origin), size = largest_component(ray.direction);
    // NaN or infinite where one of them is.
    const float sum = ray.origin.x + ray.origin.y + ray.origin.z + ray.direction.x + ray.direction.y + ray.direction.z;
    const bool traceable =
        sum - sum == 0.0f && reach <= top.origin_limit && size > 0.0f && ray.t_near >= 0.0f && ray.t_near < ray.t_far;
    if (!traceable) [[unlikely]] {
      clear(lane);
      return false;
    }
    float scale = 1.0f;
    t_of_unit[lane] = 1.0f;
    if (!(size > 0x1p-10f && size < 0x1p10f)) [[unlikely]] {
      scale = direction_scale(size);
      t_of_unit[lane] = 1.0f / scale;
    }
    float t_near = ray.t_near / scale, t_far = ray.t_far / scale;
    if (widen) {
      margin[lane] = 1e-5f * (reach + top.magnitude) / (size * scale);
      t_near = std::max(0.0f, t_near - margin[lane] - relative_margin * t_near);
      t_far += margin[lane] + relative_margin * t_far;
    }
    // Beyond this t, Embree's arithmetic overflows; no vertex is that far.
    write(lane, ray.origin, ray.direction * scale, std::min(t_near, 1e30f), t_far);
    valid[lane] = -1;
    return true;
  }

  // A lane that hits nothing even where Embree ignores `valid`.
  void clear(uint32_t lane) {
    write(lane, glm::vec3(0.0f), glm::vec3(0.0f, 0.0f, 1.0f), 1.0f, -1.0f);
    valid[lane] = 0;
    t_of_unit[lane] = 1.0f;
    margin[lane] = 0.0f;
  }

  void intersect(RTCScene scene, embree::Query& query, bool coherent, RTCFilterFunctionN filter) {
    for (uint32_t i = 0; i < N; ++i) {
      RTCHitN_geomID(hit_n(), N, i) = RTC_INVALID_GEOMETRY_ID;
      RTCHitN_instID(hit_n(), N, i, 0) = RTC_INVALID_GEOMETRY_ID;
    }
    embree::IntersectArguments arguments(query, coherent, filter);
    Types::intersect(valid.data(), scene, arguments, &packet);
  }

  void occluded(RTCScene scene, embree::Query& query, bool coherent, RTCFilterFunctionN filter) {
    embree::OccludedArguments arguments(query, coherent, filter);
    Types::occluded(valid.data(), scene, arguments, &packet.ray);
  }

  float t_far(uint32_t lane) { return RTCRayN_tfar(ray_n(), N, lane); }

  // How the lanes were set.
  std::array<float, N> t_of_unit;  // Embree's t for our distance 1
  std::array<float, N> margin;     // of Embree's t where widened, the part that does not grow with the distance

 private:
  RTCRayN* ray_n() { return reinterpret_cast<RTCRayN*>(&packet.ray); }
  RTCHitN* hit_n() { return reinterpret_cast<RTCHitN*>(&packet.hit); }

  void write(uint32_t lane, glm::vec3 origin, glm::vec3 direction, float t_near, float t_far) {
    RTCRayN* r = ray_n();
    RTCRayN_org_x(r, N, lane) = origin.x;
    RTCRayN_org_y(r, N, lane) = origin.y;
    RTCRayN_org_z(r, N, lane) = origin.z;
    RTCRayN_tnear(r, N, lane) = t_near;
    RTCRayN_dir_x(r, N, lane) = direction.x;
    RTCRayN_dir_y(r, N, lane) = direction.y;
    RTCRayN_dir_z(r, N, lane) = direction.z;
    RTCRayN_tfar(r, N, lane) = t_far;
  }

  alignas(64) typename Types::RayHit packet;
  alignas(64) std::array<int, N> valid;
};

struct LayerQuery : embree::Query {
  const TraceTable* table = nullptr;
  LayerRules rules{};
  std::array<Lane, most_lanes> lanes;
  std::array<Candidate, most_lanes*(most_layers + Lane::spare)> candidates;

  Candidate* list(uint32_t lane) { return candidates.data() + lane * (rules.layers + Lane::spare); }
};

// The columns of Embree's packet that filters read, and the hit lanes as bits. Filters hold to Embree's protocol: valid
// = 0 turns a hit away and keeps the ray's end; leaving it and writing tfar sets a new end.
struct FilterPacket {
  explicit FilterPacket(const RTCFilterFunctionNArguments& a)
      : width(a.N),
        valid(a.valid),
        ray(a.ray),
        hit(a.hit),
        t_far(&RTCRayN_tfar(a.ray, a.N, 0)),
        ray_ids(&RTCRayN_id(a.ray, a.N, 0)),
        instances(&RTCHitN_instID(a.hit, a.N, 0, 0)),
        primitives(&RTCHitN_primID(a.hit, a.N, 0)) {}

  uint32_t lanes() const {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < width; ++i) bits |= static_cast<uint32_t>(valid[i] == -1) << i;
    return bits;
  }
  Candidate candidate(uint32_t i) const { return {t_far[i], instances[i], primitives[i]}; }

  // Decided in object space by Embree's normal, with a margin: near the silhouette the recomputation decides.
  bool surely_back(uint32_t i) const {
    const glm::vec3 n(RTCHitN_Ng_x(hit, width, i), RTCHitN_Ng_y(hit, width, i), RTCHitN_Ng_z(hit, width, i));
    const glm::vec3 d(RTCRayN_dir_x(ray, width, i), RTCRayN_dir_y(ray, width, i), RTCRayN_dir_z(ray, width, i));
    const float s = glm::dot(n, d);
    return s > 0.0f && s * s > 1e-4f * glm::dot(n, n) * glm::dot(d, d);
  }

  uint32_t width;
  int* valid;
  RTCRayN* ray;
  RTCHitN* hit;
  float* t_far;
  const uint32_t *ray_ids, *instances, *primitives;
};

bool discarded(const TraceTable& table, const Ray& ray, const Candidate& candidate) {
  const TraceInstance& instance = table.instances[candidate.instance];
  Hit hit;
  return !recompute(instance, candidate.instance, candidate.primitive, ray, hit) ||
         alpha_discards(*table.snapshot, instance, hit.primitive, hit.u, hit.v);
}

void first_pass_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  const FilterPacket packet(*arguments);
  for (uint32_t lanes = packet.lanes(); lanes != 0; lanes &= lanes - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
    const uint32_t id = packet.ray_ids[i];
    Lane& lane = query.lanes[id];
    const TraceInstance& instance = query.table->instances[packet.instances[i]];
    const bool ignored = (query.rules.cull && instance.culls && packet.surely_back(i)) ||
                         (instance.discards && discarded(*query.table, *lane.ray, packet.candidate(i)));
    if (!ignored && note_candidate(lane, query.list(id), query.rules.layers, packet.t_far[i], packet.instances[i],
                                   packet.primitives[i]))
      packet.t_far[i] = lane.limit;
    else
      packet.valid[i] = 0;
  }
}

void exact_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  const FilterPacket packet(*arguments);
  for (uint32_t lanes = packet.lanes(); lanes != 0; lanes &= lanes - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
    Lane& lane = query.lanes[packet.ray_ids[i]];
    if (insert_candidate(*query.table, query.rules, lane, packet.candidate(i)))
      packet.t_far[i] = lane.limit;
    else
      packet.valid[i] = 0;
  }
}

struct CutOutQuery : embree::Query {
  const TraceTable* table = nullptr;
  const Ray* rays = nullptr;  // of the packet
};

void cut_out_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& query = embree::state_of<CutOutQuery>(*arguments);
  const FilterPacket packet(*arguments);
  for (uint32_t lanes = packet.lanes(); lanes != 0; lanes &= lanes - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
    const Candidate candidate = packet.candidate(i);
    if (query.table->instances[candidate.instance].discards &&
        discarded(*query.table, query.rays[packet.ray_ids[i]], candidate))
      packet.valid[i] = 0;
  }
}

// The nearest surfaces of up to N rays.
template <unsigned N>
class LayerTracer {
 public:
  LayerTracer(const TraceTable& table, const TopLevel& top, uint32_t mask, LayerRules rules, bool coherent)
      : table_(table), top_(top), coherent_(coherent), packet_(mask) {
    query_.table = &table;
    query_.rules = rules;
  }

  void trace(std::span<const Ray> rays, Hit* hits, uint32_t* counts) {
    std::array<bool, N> wanted;
    for (uint32_t i = 0; i < N; ++i) wanted[i] = i < rays.size();
    const bool any = fill(rays, hits, wanted);
    if (any) packet_.intersect(top_.scene.get(), query_, coherent_, first_pass_filter);
    bool again = false;
    for (uint32_t i = 0; i < rays.size(); ++i) {
      wanted[i] = any && !resolve_candidates(table_, query_.rules, query_.lanes[i], query_.list(i));
      again |= wanted[i];
    }
    if (again) {
      fill(rays, hits, wanted);
      packet_.intersect(top_.scene.get(), query_, false, exact_filter);
    }
    for (uint32_t i = 0; i < rays.size(); ++i) counts[i] = query_.lanes[i].hit_count;
  }

 private:
  // Sets the wanted lanes, clears the others; false where no ray is left to trace.
  bool fill(std::span<const Ray> rays, Hit* hits, const std::array<bool, N>& wanted) {
    bool any = false;
    for (uint32_t i = 0; i < N; ++i) {
      if (!wanted[i]) {
        packet_.clear(i);
        continue;
      }
      any |= packet_.set(i, rays[i], top_, true);
      query_.lanes[i] = {.ray = &rays[i],
                         .hits = hits + size_t{i} * query_.rules.layers,
                         .hit_count = 0,
                         .candidate_count = 0,
                         .lossy = false,
                         .limit = std::numeric_limits<float>::infinity(),
                         .margin = packet_.margin[i],
                         .t_of_unit = packet_.t_of_unit[i]};
    }
    return any;
  }

  const TraceTable& table_;
  const TopLevel& top_;
  bool coherent_;
  RayPacket<N> packet_;
  LayerQuery query_;
};

template <unsigned N>
void trace_layers(const TraceTable& table, const TopLevel& top, uint32_t mask, LayerRules rules, bool coherent,
                  std::span<const Ray> rays, Hit* hits, uint32_t* counts) {
  LayerTracer<N> tracer(table, top, mask, rules, coherent);
  for (size_t first = 0; first < rays.size(); first += N)
    tracer.trace(rays.subspan(first, std::min<size_t>(N, rays.size() - first)), hits + first * rules.layers,
                 counts + first);
}

template <unsigned N>
void trace_occlusion(const TraceTable& table, const TopLevel& top, bool cut_outs, bool coherent,
                     std::span<const Ray> rays, uint8_t* occluded) {
  RayPacket<N> packet(mask_shadow);
  CutOutQuery query;
  query.table = &table;
  for (size_t first = 0; first < rays.size(); first += N) {
    query.rays = rays.data() + first;
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.size() - first));
    std::array<bool, N> active{};
    bool any = false;
    for (uint32_t i = 0; i < N; ++i) {
      if (i >= count) {
        packet.clear(i);
        continue;
      }
      active[i] = packet.set(i, rays[first + i], top, false);
      any |= active[i];
    }
    if (any) packet.occluded(top.scene.get(), query, coherent, cut_outs ? cut_out_filter : nullptr);
    // Embree says "occluded" by tfar = -inf.
    for (uint32_t i = 0; i < count; ++i) occluded[first + i] = active[i] && packet.t_far(i) < 0.0f ? 1 : 0;
  }
}

template <unsigned N>
void trace_raw(const TopLevel& top, uint32_t mask, bool coherent, std::span<const Ray> rays, float* t_far) {
  RayPacket<N> packet(mask);
  embree::Query query;
  for (size_t first = 0; first < rays.size(); first += N) {
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.size() - first));
    std::array<bool, N> active{};
    for (uint32_t i = 0; i < N; ++i) {
      if (i < count)
        active[i] = packet.set(i, rays[first + i], top, false);
      else
        packet.clear(i);
    }
    packet.intersect(top.scene.get(), query, coherent, nullptr);
    for (uint32_t i = 0; i < count; ++i)
      t_far[first + i] = active[i] ? packet.t_far(i) / packet.t_of_unit[i] : rays[first + i].t_far;
  }
}

// Calls `function` with the packet width as a constant.
template <typename Function>
void with_width(uint32_t width, Function function) {
  switch (width) {
    case 16:
      return function(std::integral_constant<unsigned, 16>{});
    case 8:
      return function(std::integral_constant<unsigned, 8>{});
    case 4:
      return function(std::integral_constant<unsigned, 4>{});
    default:
      return function(std::integral_constant<unsigned, 1>{});
  }
}

MeshScenes build_meshes(RTCDevice device, const model::Snapshot& snapshot, const MeshScenes& before) {
  MeshScenes meshes;
  for (const model::Instance& instance : snapshot.instances) {
    const std::shared_ptr<const model::Mesh>& mesh = snapshot.meshes[instance.mesh];
    std::shared_ptr<const MeshScene>& entry = meshes[mesh.get()];
    if (entry) continue;
    const auto known = before.find(mesh.get());
    entry = known != before.end() ? known->second : std::make_shared<const MeshScene>(build_mesh_scene(device, mesh));
  }
  return meshes;
}

bool has_cut_outs(const TraceTable& table) {
  return std::any_of(table.instances.begin(), table.instances.end(),
                     [](const TraceInstance& i) { return i.discards && !i.material->translucent; });
}

}  // namespace

struct Intersector::State {
  std::string isa;
  DeviceHandle device;
  uint32_t width = 1;
  MeshScenes meshes;
  TraceTable table;
  TopLevel layers, world;
  bool cut_outs = false;
};

Intersector::Intersector(uint32_t threads, const std::string& isa) : state_(std::make_unique<State>()) {
  state_->device = open_device(threads, isa);
  state_->isa = isa_in_use(state_->device.get(), isa);
  state_->width = native_packet_width(state_->device.get());
  set_scene(std::make_shared<const model::Snapshot>());
}

Intersector::~Intersector() = default;

void Intersector::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  const FlushDenormals flush;
  const RTCDevice device = state_->device.get();
  MeshScenes meshes = build_meshes(device, *snapshot, state_->meshes);
  TopLevel layers = build_top_level(device, *snapshot, meshes, layers_mask);
  TopLevel world = build_top_level(device, *snapshot, meshes, world_mask);
  TraceTable table = build_trace_table(std::move(snapshot));
  state_->cut_outs = has_cut_outs(table);
  state_->layers = std::move(layers);
  state_->world = std::move(world);
  state_->table = std::move(table);
  state_->meshes = std::move(meshes);
}

void Intersector::nearest_layers(LayerSet set, std::span<const Ray> rays, uint32_t layers, bool coherent, Hit* hits,
                                 uint32_t* counts) const {
  const FlushDenormals flush;
  const LayerRules rules{.layers = std::min(layers, most_layers), .cull = true};
  if (rules.layers == 0 || !has_translucent(set)) {
    std::fill_n(counts, rays.size(), 0u);
    return;
  }
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->table, state_->layers, mask_of(set), rules, coherent, rays, hits, counts);
  });
}

void Intersector::nearest_opaque(std::span<const Ray> rays, bool coherent, Hit* hits) const {
  const FlushDenormals flush;
  constexpr size_t chunk = 256;
  std::array<uint32_t, chunk> counts;
  for (size_t first = 0; first < rays.size(); first += chunk) {
    const auto part = rays.subspan(first, std::min(chunk, rays.size() - first));
    with_width(state_->width, [&](auto n) {
      trace_layers<n>(state_->table, state_->world, mask_reflection, {.layers = 1, .cull = false}, coherent, part,
                      hits + first, counts.data());
    });
    for (size_t i = 0; i < part.size(); ++i)
      if (counts[i] == 0) hits[first + i] = {INFINITY, 0.0f, 0.0f, no_instance, 0, false};
  }
}

void Intersector::occluded(std::span<const Ray> rays, bool coherent, uint8_t* occluded) const {
  const FlushDenormals flush;
  with_width(state_->width, [&](auto n) {
    trace_occlusion<n>(state_->table, state_->world, state_->cut_outs, coherent, rays, occluded);
  });
}

bool Intersector::has_translucent(LayerSet set) const {
  return (state_->layers.mask_bits & mask_of(set)) != 0;
}

uint32_t Intersector::packet_width() const {
  return state_->width;
}

std::string Intersector::isa() const {
  return state_->isa;
}

std::string Intersector::version() const {
  return embree_version(state_->device.get());
}

void Intersector::raw_intersect(LayerSet set, std::span<const Ray> rays, bool coherent, float* t_far) const {
  const FlushDenormals flush;
  with_width(state_->width, [&](auto n) { trace_raw<n>(state_->layers, mask_of(set), coherent, rays, t_far); });
}

}  // namespace sideray::rt
