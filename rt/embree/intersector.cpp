#include "rt/embree/intersector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "model/material.h"
#include "rt/base/float_mode.h"
#include "rt/embree/alpha_test.h"
#include "rt/embree/embree.h"
#include "rt/embree/embree_scene.h"
#include "rt/embree/filter_packet.h"
#include "rt/embree/layer_collector.h"
#include "rt/embree/nearest_collector.h"
#include "rt/embree/ray_packet.h"
#include "rt/embree/recompute.h"
#include "rt/embree/top_level.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {
namespace {

constexpr uint32_t most_lanes = 16, most_layers = 64;

// These are the instance masks of the two top-level scenes.
enum : uint32_t { mask_in_layers = 1, mask_translucent = 2, mask_sprites = 4, mask_tints = 8 };
enum : uint32_t { mask_reflection = 1, mask_shadow = 2, mask_ao = 4, mask_opaque = 8 };

uint32_t layers_mask(const model::Material& material, const model::Instance& instance) {
  if (!material.translucent) return 0;
  if (instance.sprites != 0) return mask_sprites;
  const bool in_layers =
      material.traceable && (instance.visibility & SIDERAY_VISIBLE_LAYERS) && instance.surface_id != 0;
  return mask_translucent | (in_layers ? mask_in_layers : 0u) |
         (model::tints_light(material, instance) ? mask_tints : 0u);
}

uint32_t world_mask(const model::Material& material, const model::Instance& instance) {
  if (material.translucent) return 0;
  return mask_opaque | ((instance.visibility & SIDERAY_VISIBLE_REFLECTION) ? mask_reflection : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_SHADOW) ? mask_shadow : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_AO) ? mask_ao : 0u);
}

uint32_t mask_of(LayerSet set) {
  if (set == LayerSet::with_sprites) return mask_translucent | mask_sprites;
  if (set == LayerSet::tints_light) return mask_tints;
  return set == LayerSet::visible_in_layers ? mask_in_layers : mask_translucent;
}

uint32_t mask_of(OpaqueSet set) {
  switch (set) {
    case OpaqueSet::visible_in_reflection:
      return mask_reflection;
    case OpaqueSet::casts_shadow:
      return mask_shadow;
    case OpaqueSet::occludes_sky:
      return mask_ao;
    default:
      return mask_opaque;
  }
}

LayerRules rules_of(uint32_t layers, bool cull, Cone cone) {
  layers = std::min(layers, most_layers);
  return {.layers = layers, .kept = layers, .cull = cull, .cone = cone};
}

struct LayerQuery : embree::Query {
  const TraceTable* table = nullptr;
  LayerRules rules{};
  std::array<Lane, most_lanes> lanes;
  std::array<Candidate, most_lanes*(most_layers + Lane::spare)> candidates;

  uint32_t stride() const { return rules.layers + Lane::spare; }
  Candidate* list(uint32_t lane) { return candidates.data() + lane * stride(); }

  std::span<const Ray> rays;  // those of the packet
  Hit* hits = nullptr;
  // `nearest` is used where one layer is wanted; lists serve only the lanes whose bit is in `listed`.
  NearestBlock nearest{};
  uint32_t listed = 0;

  // Makes a lane empty.
  void start_lane(uint32_t i) {
    Lane& lane = lanes[i];
    lane.ray = &rays[i];
    lane.hits = hits + size_t{i} * rules.kept;
    lane.hit_count = lane.candidate_count = 0;
    lane.lossy = false;
    lane.limit = std::numeric_limits<float>::infinity();
    lane.margin = nearest.margin[i];
    lane.begin = nearest.begin[i];
    lane.distance_of_unit = nearest.distance_of_unit[i];
  }
};

bool discarded(const TraceTable& table, const Ray& ray, const Candidate& candidate, Cone cone) {
  const TraceInstance& instance = table.instances[candidate.instance];
  Hit hit;
  return !recompute(instance, candidate.instance, candidate.primitive, ray, hit) ||
         alpha_discards(*table.snapshot, instance, ray, hit, cone);
}

// Returns whether a candidate that may lie before its ray's beginning does, and so does not count. Mostly it is the surface
// that the ray comes from: kept, it would take the place of one that counts, and the ray would have to be traced again.
bool lies_before(const TraceTable& table, const Ray& ray, float begin, const Candidate& candidate) {
  if (candidate.t > begin) return false;
  Hit hit;
  return !recompute(table.instances[candidate.instance], candidate.instance, candidate.primitive, ray, hit);
}

template <unsigned N>
void first_pass_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    const uint32_t id = packet.ray(i), instance = packet.instance(i);
    Lane& lane = query.lanes[id];
    const uint8_t traits = query.table->traits[instance];
    if ((traits & TraceTable::trait_culls) && query.rules.cull && packet.surely_back(i)) return false;
    if ((traits & TraceTable::trait_discards) &&
        discarded(*query.table, *lane.ray, packet.candidate(i), query.rules.cone))
      return false;
    if (lies_before(*query.table, *lane.ray, lane.begin, packet.candidate(i))) return false;
    if (!note_candidate(lane, query.list(id), query.rules.layers, packet.t_far(i), instance, packet.primitive(i)))
      return false;
    packet.t_far(i) = lane.limit;
    // The recomputation, soon, begins with the triangle's vertices.
    __builtin_prefetch(query.table->instances[instance].triangles + packet.primitive(i));
    return true;
  });
}

// Puts a candidate that is within rounding of the only one, or of others, on the lane's list. Returns whether it
// narrowed the lane's limit.
bool note_on_list(LayerQuery& query, uint32_t i, const Candidate& candidate) {
  NearestBlock& nearest = query.nearest;
  Lane& lane = query.lanes[i];
  if (!(query.listed >> i & 1u)) {
    query.listed |= 1u << i;
    query.start_lane(i);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    if (nearest.t[i] < infinity)  // there is one, unless this is the first and so far off that its limit overflows
      note_candidate(lane, query.list(i), 1, nearest.t[i], nearest.instance[i], nearest.primitive[i]);
    nearest.t[i] = -infinity;
  }
  if (!note_candidate(lane, query.list(i), 1, candidate.t, candidate.instance, candidate.primitive)) return false;
  nearest.limit[i] = lane.limit;
  return true;
}

// Does the work of first_pass_filter for one layer.
template <unsigned N>
void nearest_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  const TraceTable& table = *query.table;
  if (table.all_traits != 0)
    for_each_hit<N>(*arguments, [&](const FilterPacket<N>& packet, uint32_t i) {
      const uint8_t traits = table.traits[packet.instance(i)];
      if ((traits & TraceTable::trait_culls) && query.rules.cull && packet.surely_back(i)) return false;
      return !(traits & TraceTable::trait_discards) ||
             !discarded(table, query.rays[i], packet.candidate(i), query.rules.cone);
    });
  const NamedHits named{arguments->valid, &RTCRayN_tfar(arguments->ray, N, 0), &RTCHitN_instID(arguments->hit, N, 0, 0),
                        &RTCHitN_primID(arguments->hit, N, 0)};
  if (!query.nearest.note(named, N)) return;
  const FilterPacket<N> packet{*arguments};
  for (uint32_t i = 0; i < N; ++i) {
    if (!query.nearest.close[i]) continue;
    const Candidate candidate = packet.candidate(i);
    if (lies_before(table, query.rays[i], query.nearest.begin[i], candidate) || !note_on_list(query, i, candidate))
      continue;
    packet.valid(i) = -1;
    packet.t_far(i) = query.lanes[i].limit;
  }
}

template <unsigned N>
void exact_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<LayerQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    Lane& lane = query.lanes[packet.ray(i)];
    if (!insert_candidate(*query.table, query.rules, lane, packet.candidate(i))) return false;
    packet.t_far(i) = lane.limit;
    return true;
  });
}

struct CutOutQuery : embree::Query {
  const TraceTable* table = nullptr;
  const Ray* rays = nullptr;  // those of the packet
};

template <unsigned N>
void cut_out_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& query = embree::state_of<CutOutQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    return !(query.table->traits[packet.instance(i)] & TraceTable::trait_discards) ||
           !discarded(*query.table, query.rays[packet.ray(i)], packet.candidate(i), Cone{});
  });
}

// Finds the nearest surfaces of up to N rays.
template <unsigned N>
class PacketTracer {
 public:
  PacketTracer(const TraceTable& table, const TopLevel& top, uint32_t mask, LayerRules rules, bool coherent)
      : table_(table), top_(top), all_coherent_(coherent), packet_(mask) {
    query_.table = &table;
    query_.rules = rules;
  }

  // `known`, where it is not null, receives up to where on each ray there are no other surfaces, and hits behind that are
  // left out, but for the first.
  void trace(std::span<const Ray> rays, Hit* hits, uint32_t* counts, double* known = nullptr) {
    const auto count = static_cast<uint32_t>(rays.size());
    query_.rays = rays;
    query_.hits = hits;
    // The rays of one packet often go the same way even where not all rays do.
    coherent_ = all_coherent_ || directions_agree(rays);
    const uint32_t wanted = (1u << count) - 1u;
    const uint32_t again = query_.rules.layers == 1 ? trace_nearest(wanted, counts) : trace_first(wanted, counts);
    if (known) cut_to_known(wanted & ~again, query_.listed, counts, known);
    if (again == 0) return;
    set(again);
    start_lanes(again);
    packet_.intersect(top_.scene.get(), query_, false, exact_filter<N>);
    take_counts(again, counts);
    if (known) cut_to_known(again, again, counts, known);
  }

 private:
  // Runs the first passes, and returns the lanes, as bits, that they could not finish.
  uint32_t trace_first(uint32_t wanted, uint32_t* counts) {
    const bool any = set(wanted);
    start_lanes(wanted);
    uint32_t again = 0;
    if (any) {
      packet_.intersect(top_.scene.get(), query_, coherent_, first_pass_filter<N>);
      packet_.copy_rays(block_);
      again = resolve_lists(wanted);
    }
    take_counts(wanted, counts);
    return again;
  }

  uint32_t trace_nearest(uint32_t wanted, uint32_t* counts) {
    std::fill_n(counts, query_.rays.size(), 0u);
    if (!set(wanted)) return 0;
    query_.nearest.clear();
    query_.listed = 0;
    packet_.intersect(top_.scene.get(), query_, coherent_, nearest_filter<N>);
    packet_.copy_rays(block_);
    uint32_t again = resolve_nearest(table_, query_.rules, query_.rays, query_.nearest, block_, query_.hits, counts);
    if (query_.listed != 0) {
      again |= resolve_lists(query_.listed);
      take_counts(query_.listed, counts);
    }
    return again;
  }

  uint32_t resolve_lists(uint32_t lanes) {
    return resolve_candidates(table_, query_.rules, query_.lanes, lanes, query_.candidates.data(), query_.stride(),
                              block_);
  }

  // Sets the lanes whose bit is wanted and clears the others; returns false where no ray is left to trace.
  bool set(uint32_t wanted) {
    const uint32_t traced = packet_.set(query_.rays, wanted, top_, true);
    std::copy_n(packet_.margin.begin(), N, query_.nearest.margin);
    std::copy_n(packet_.begin.begin(), N, query_.nearest.begin);
    std::copy_n(packet_.distance_of_unit.begin(), N, query_.nearest.distance_of_unit);
    return traced != 0;
  }

  void start_lanes(uint32_t lanes) {
    for (; lanes != 0; lanes &= lanes - 1) query_.start_lane(static_cast<uint32_t>(std::countr_zero(lanes)));
  }

  void take_counts(uint32_t lanes, uint32_t* counts) const {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
      counts[i] = query_.lanes[i].hit_count;
    }
  }

  void cut_to_known(uint32_t lanes, uint32_t listed, uint32_t* counts, double* known) const {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
      known[i] = cut_to_known(i, (listed >> i & 1u) ? query_.lanes[i].limit : query_.nearest.limit[i], counts[i]);
    }
  }

  // Returns up to where all is known on the ray of a lane, and leaves out its hits behind that, but for the first.
  double cut_to_known(uint32_t i, float limit, uint32_t& count) const {
    if (count == 0) return std::numeric_limits<double>::infinity();
    // What was rejected, farther than the limit, may be nearer than Embree said by half the margin.
    const float sure = limit - 0.5f * (query_.nearest.margin[i] + relative_margin * limit);
    const Hit* hits = query_.hits + size_t{i} * query_.rules.kept;
    double known = static_cast<double>(sure) * static_cast<double>(query_.nearest.distance_of_unit[i]);
    if (count == query_.rules.kept) known = std::min(known, hits[count - 1].distance);
    known = std::max(known, hits[0].distance);
    while (hits[count - 1].distance > known) --count;
    return known;
  }

  const TraceTable& table_;
  const TopLevel& top_;
  bool all_coherent_, coherent_ = false;  // all packets; this one
  RayPacket<N> packet_;
  LayerQuery query_;
  CandidateBlock block_{};
};

template <unsigned N>
void trace_layers(const TraceTable& table, const TopLevel& top, uint32_t mask, LayerRules rules, bool coherent,
                  std::span<const Ray> rays, Hit* hits, uint32_t* counts, double* known = nullptr) {
  PacketTracer<N> tracer(table, top, mask, rules, coherent);
  for (size_t first = 0; first < rays.size(); first += N)
    tracer.trace(rays.subspan(first, std::min<size_t>(N, rays.size() - first)), hits + first * rules.kept,
                 counts + first, known ? known + first : nullptr);
}

template <unsigned N>
void trace_occlusion(const TraceTable& table, const TopLevel& top, uint32_t mask, bool cut_outs, bool coherent,
                     std::span<const Ray> rays, uint8_t* occluded) {
  RayPacket<N> packet(mask);
  CutOutQuery query;
  query.table = &table;
  for (size_t first = 0; first < rays.size(); first += N) {
    query.rays = rays.data() + first;
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.size() - first));
    const uint32_t traced = packet.set(rays.subspan(first, count), (1u << count) - 1u, top, false);
    if (traced) packet.occluded(top.scene.get(), query, coherent, cut_outs ? cut_out_filter<N> : nullptr);
    // Embree says "occluded" by tfar = -inf.
    for (uint32_t i = 0; i < count; ++i) occluded[first + i] = (traced >> i & 1u) && packet.t_far(i) < 0.0f ? 1 : 0;
  }
}

struct ColumnCutOutQuery : embree::Query {
  const TraceTable* table = nullptr;
  const RayColumns* rays = nullptr;
  size_t first = 0;  // of the packet's
};

template <unsigned N>
void column_cut_out_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& query = embree::state_of<ColumnCutOutQuery>(*arguments);
  for_each_hit<N>(*arguments, [&query](const FilterPacket<N>& packet, uint32_t i) {
    return !(query.table->traits[packet.instance(i)] & TraceTable::trait_discards) ||
           !discarded(*query.table, (*query.rays)[query.first + packet.ray(i)], packet.candidate(i), Cone{});
  });
}

template <unsigned N>
void trace_columns(const TraceTable& table, const TopLevel& top, uint32_t mask, bool cut_outs, bool coherent,
                   const RayColumns& rays, uint8_t* occluded) {
  RayPacket<N> packet(mask);
  ColumnCutOutQuery query;
  query.table = &table;
  query.rays = &rays;
  for (size_t first = 0; first < rays.count; first += N) {
    query.first = first;
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.count - first));
    const uint32_t traced = packet.set(rays, first, top, false);
    if (traced) packet.occluded(top.scene.get(), query, coherent, cut_outs ? column_cut_out_filter<N> : nullptr);
    for (uint32_t i = 0; i < count; ++i) occluded[first + i] = (traced >> i & 1u) && packet.t_far(i) < 0.0f ? 1 : 0;
  }
}

template <unsigned N>
void trace_raw(const TopLevel& top, uint32_t mask, bool coherent, std::span<const Ray> rays, float* t_far) {
  RayPacket<N> packet(mask);
  embree::Query query;
  for (size_t first = 0; first < rays.size(); first += N) {
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.size() - first));
    const uint32_t traced = packet.set(rays.subspan(first, count), (1u << count) - 1u, top, false);
    packet.intersect(top.scene.get(), query, coherent, nullptr);
    for (uint32_t i = 0; i < count; ++i)
      t_far[first + i] = (traced >> i & 1u) ? packet.t_far(i) * packet.distance_of_unit[i] : rays[first + i].t_far;
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

// rtcOccluded16 with the coherent flag reads uninitialised stack in scenes with instances and may never return (Embree
// 3.13.5, AVX-512). Eight lanes are sound, and native wherever sixteen are; without the flag so are sixteen.
uint32_t occlusion_width(uint32_t native, bool coherent) {
  return coherent ? std::min(native, 8u) : native;
}

bool has_cut_outs(const TraceTable& table) {
  return std::any_of(table.instances.begin(), table.instances.end(),
                     [](const TraceInstance& i) { return i.discards && !i.material->translucent; });
}

// Returns whether a hit with the instance counts for the same rays: `a` and `b` are of two tables.
bool has_same_holes(const TraceTable& a, const TraceTable& b, size_t i) {
  const TraceInstance &x = a.instances[i], &y = b.instances[i];
  const sideray_material_desc &m = x.material->desc, &n = y.material->desc;
  sideray_texture_slot slot = m.base_color_texture, other = n.base_color_texture;
  const auto texels = [](const TraceTable& table, const sideray_texture_slot& from) {
    return from.texture == 0 ? nullptr : table.snapshot->textures[from.texture - 1].get();
  };
  if (texels(a, slot) != texels(b, other)) return false;
  slot.texture = other.texture = 0;
  return x.discards == y.discards && x.mesh == y.mesh && m.alpha_mode == n.alpha_mode &&
         m.alpha_cutoff == n.alpha_cutoff && m.base_color[3] == n.base_color[3] &&
         std::memcmp(&slot, &other, sizeof(slot)) == 0;
}

// Returns whether the opaque instances that both tables have got other holes. What came or went counts elsewhere.
bool holes_differ(const TraceTable& a, const TraceTable& b) {
  for (size_t i = 0; i < std::min(a.instances.size(), b.instances.size()); ++i) {
    const bool cut_out = (a.instances[i].discards && !a.instances[i].material->translucent) ||
                         (b.instances[i].discards && !b.instances[i].material->translucent);
    if (cut_out && !has_same_holes(a, b, i)) return true;
  }
  return false;
}

}  // namespace

bool directions_agree(std::span<const Ray> rays) {
  constexpr float same_way = 0.95f;
  size_t agreeing = 0;
  for (size_t i = 1; i < rays.size(); ++i) agreeing += glm::dot(rays[i - 1].direction, rays[i].direction) > same_way;
  return agreeing * 10 >= rays.size() * 9;
}

struct Intersector::State {
  std::string isa;
  DeviceHandle device;
  uint32_t width = 1;
  MeshScenes meshes;
  TraceTable table;
  TopLevel layers, world;
  bool cut_outs = false;
  uint64_t opaque_revision = 0;

  // Drops both scenes: half an update may be in them.
  void clear() {
    layers = {};
    world = {};
    meshes.clear();
    table = {};
    cut_outs = false;
  }
};

Intersector::Intersector(const std::string& isa) : state_(std::make_unique<State>()) {
  state_->device = open_device(isa);
  state_->isa = isa_in_use(state_->device.get(), isa);
  state_->width = native_packet_width(state_->device.get());
  set_scene(std::make_shared<const model::Snapshot>());
}

Intersector::~Intersector() = default;

void Intersector::set_scene(std::shared_ptr<const model::Snapshot> snapshot, const SceneUpdate& update) {
  const FlushDenormals flush;
  const RTCDevice device = state_->device.get();
  try {
    MeshScenes meshes = build_meshes(device, *snapshot, update, state_->meshes);
    state_->layers.set_up(device, *snapshot, meshes, update.culled, layers_mask);
    state_->world.set_up(device, *snapshot, meshes, update.culled, world_mask);
    state_->layers.commit(device);
    state_->world.commit(device);
    TraceTable table = build_trace_table(std::move(snapshot), state_->table);
    const TopLevel::Changes& changes = state_->world.changes();
    const bool moved = changes.attached + changes.changed + changes.detached != 0;
    state_->opaque_revision += moved || holes_differ(state_->table, table);
    state_->table = std::move(table);
    state_->cut_outs = has_cut_outs(state_->table);
    state_->meshes = std::move(meshes);
  } catch (...) {
    state_->clear();
    ++state_->opaque_revision;
    throw;
  }
}

void Intersector::nearest_layers(LayerSet set, std::span<const Ray> rays, uint32_t layers, bool coherent, Hit* hits,
                                 uint32_t* counts, Cone cone, bool cull) const {
  const FlushDenormals flush;
  const LayerRules rules = rules_of(layers, cull, cone);
  if (rules.layers == 0 || !has_translucent(set)) {
    std::fill_n(counts, rays.size(), 0u);
    return;
  }
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->table, state_->layers, mask_of(set), rules, coherent, rays, hits, counts);
  });
}

void Intersector::nearest_places(LayerSet set, std::span<const Ray> rays, bool coherent, Hit* hits, uint32_t* counts,
                                 double* known, Cone cone, bool cull) const {
  const FlushDenormals flush;
  if (!has_translucent(set)) {
    std::fill_n(counts, rays.size(), 0u);
    std::fill_n(known, rays.size(), std::numeric_limits<double>::infinity());
    return;
  }
  const LayerRules rules{.layers = 1, .kept = most_at_place, .cull = cull, .cone = cone};
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->table, state_->layers, mask_of(set), rules, coherent, rays, hits, counts, known);
  });
}

void Intersector::nearest_opaque(std::span<const Ray> rays, bool coherent, Hit* hits, OpaqueSet set, Cone cone,
                                 bool cull) const {
  const uint32_t mask = mask_of(set);
  const FlushDenormals flush;
  constexpr size_t chunk = 256;
  std::array<uint32_t, chunk> counts;
  for (size_t first = 0; first < rays.size(); first += chunk) {
    const auto part = rays.subspan(first, std::min(chunk, rays.size() - first));
    with_width(state_->width, [&](auto n) {
      trace_layers<n>(state_->table, state_->world, mask, rules_of(1, cull, cone), coherent, part, hits + first,
                      counts.data());
    });
    for (size_t i = 0; i < part.size(); ++i)
      if (counts[i] == 0) hits[first + i] = {INFINITY, 0.0f, 0.0f, no_instance, 0, false};
  }
}

void Intersector::nearest_opaque_layers(std::span<const Ray> rays, uint32_t layers, bool coherent, Hit* hits,
                                        uint32_t* counts, Cone cone) const {
  const FlushDenormals flush;
  const LayerRules rules = rules_of(layers, true, cone);
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->table, state_->world, mask_opaque, rules, coherent, rays, hits, counts);
  });
}

void Intersector::occluded(std::span<const Ray> rays, bool coherent, uint8_t* occluded, OpaqueSet set) const {
  const FlushDenormals flush;
  with_width(occlusion_width(state_->width, coherent), [&](auto n) {
    trace_occlusion<n>(state_->table, state_->world, mask_of(set), state_->cut_outs, coherent, rays, occluded);
  });
}

void Intersector::occluded(const RayColumns& rays, bool coherent, uint8_t* occluded, OpaqueSet set) const {
  const FlushDenormals flush;
  with_width(occlusion_width(state_->width, coherent), [&](auto n) {
    trace_columns<n>(state_->table, state_->world, mask_of(set), state_->cut_outs, coherent, rays, occluded);
  });
}

uint64_t Intersector::opaque_revision() const {
  return state_->opaque_revision;
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
