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
#include "rt/embree/embree.h"
#include "rt/embree/embree_scene.h"
#include "rt/embree/filter_packet.h"
#include "rt/embree/packet_gatherer.h"
#include "rt/embree/packet_tracer.h"
#include "rt/embree/ray_packet.h"
#include "rt/embree/top_level.h"
#include "rt/embree/trace_table.h"
#include "rt/reach/tile_reach.h"

namespace sideray::rt {
namespace {

// The instance masks of the two top-level scenes.
enum : uint32_t { mask_in_layers = 1, mask_translucent = 2, mask_sprites = 4, mask_tints = 8 };
enum : uint32_t { mask_reflection = 1, mask_shadow = 2, mask_ao = 4, mask_opaque = 8, mask_walls = 16 };

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
  const uint32_t reflected = mask_reflection | (material.discards ? 0u : mask_walls);
  return mask_opaque | ((instance.visibility & SIDERAY_VISIBLE_REFLECTION) ? reflected : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_SHADOW) ? mask_shadow : 0u) |
         ((instance.visibility & SIDERAY_VISIBLE_AO) ? mask_ao : 0u);
}

uint32_t mask_of(LayerSet set) {
  if (set == LayerSet::with_sprites) return mask_translucent | mask_sprites;
  if (set == LayerSet::tints_light) return mask_tints;
  return set == LayerSet::visible_in_layers ? mask_in_layers : mask_translucent;
}

bool meets_sprites(LayerSet set) {
  return set == LayerSet::with_sprites;
}

uint32_t mask_of(OpaqueSet set) {
  switch (set) {
    case OpaqueSet::visible_in_reflection:
      return mask_reflection;
    case OpaqueSet::casts_shadow:
      return mask_shadow;
    case OpaqueSet::occludes_sky:
      return mask_ao;
    case OpaqueSet::walls:
      return mask_walls;
    default:
      return mask_opaque;
  }
}

// Carries the state of any-hit rays through Embree. The rays are those of `columns` from `first` on, or `rays` if it is
// null.
struct OcclusionQuery : embree::Query {
  const TraceTable* table = nullptr;
  const Ray* rays = nullptr;  // those of the packet
  const RayColumns* columns = nullptr;
  size_t first = 0;
  bool cut_outs = false;
  const float *begin = nullptr, *end = nullptr;  // RayPacket's
  uint32_t open = 0;                             // bits of the rays that have hit something near an edge
  std::array<double, most_packet_lanes> offset;  // their offset, as edge_offset() returns it

  Ray ray(uint32_t i) const { return columns ? (*columns)[first + i] : rays[i]; }
};

// Accepts hits that Embree's rounding cannot change: those well inside a triangle and between the ray's ends. Other
// hits are recomputed; if one is too near an edge to decide, the ray goes on.
template <unsigned N>
void occlusion_filter(const RTCFilterFunctionNArguments* arguments) {
  auto& query = embree::state_of<OcclusionQuery>(*arguments);
  const float* const u = &RTCHitN_u(arguments->hit, N, 0);
  const float* const v = &RTCHitN_v(arguments->hit, N, 0);
  const float* const t = &RTCRayN_tfar(arguments->ray, N, 0);
  alignas(64) std::array<int, N> clear;
  for (uint32_t i = 0; i < N; ++i)
    clear[i] = -(static_cast<int>(u[i] > edge_weight) & static_cast<int>(v[i] > edge_weight) &
                 static_cast<int>(u[i] + v[i] < 1.0f - edge_weight) & static_cast<int>(t[i] > query.begin[i]) &
                 static_cast<int>(t[i] < query.end[i]));
  if (!query.cut_outs && (lanes_of(arguments->valid, N) & ~lanes_of(clear.data(), N)) == 0) return;
  for_each_hit<N>(*arguments, [&query, &clear](const FilterPacket<N>& packet, uint32_t i) {
    const uint32_t id = packet.ray(i);
    const bool discards = query.table->traits[packet.instance(i)] & TraceTable::trait_discards;
    if (clear[i] && !discards) return true;
    const Ray ray = query.ray(id);
    Hit hit;
    double offset = 0.0;
    const Meeting meeting = decide_alone(*query.table, ray, {packet.instance(i), packet.primitive(i)}, hit, offset);
    if (meeting == Meeting::open) {
      query.offset[id] = (query.open >> id & 1u) ? std::max(query.offset[id], offset) : offset;
      query.open |= 1u << id;
    }
    if (meeting != Meeting::hit) return false;
    return !discards || !alpha_discards(*query.table->snapshot, query.table->instances[hit.instance], ray, hit, Cone{});
  });
}

// Rays in either form.
struct RaysOrColumns {
  std::span<const Ray> rays;
  const RayColumns* columns = nullptr;
  size_t size() const { return columns ? columns->count : rays.size(); }
};

template <unsigned N>
void trace_occlusion(const MaskedInstances& among, bool cut_outs, bool coherent, const RaysOrColumns& traced_rays,
                     uint8_t* occluded) {
  const auto [rays, columns] = traced_rays;
  const size_t size = traced_rays.size();
  const TopLevel& top = among.top;
  RayPacket<N> packet(among.mask);
  OcclusionQuery query;
  query.table = &among.table;
  query.columns = columns;
  query.cut_outs = cut_outs;
  query.begin = packet.begin.data();
  query.end = packet.end.data();
  for (size_t first = 0; first < size; first += N) {
    query.rays = columns ? nullptr : rays.data() + first;
    query.first = first;
    query.open = 0;
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, size - first));
    const uint32_t traced = columns ? packet.set(*columns, first, top, true)
                                    : packet.set(rays.subspan(first, count), (1u << count) - 1u, top, true);
    if (traced) packet.occluded(top.scene.get(), query, coherent, occlusion_filter<N>);
    // Embree reports an occluded ray by tfar = -inf.
    for (uint32_t i = 0; i < count; ++i) {
      bool met = (traced >> i & 1u) && packet.t_far(i) < 0.0f;
      if (!met && (query.open >> i & 1u)) {
        EdgeTracer<N> tracer(among);
        met = !tracer.trace(query.ray(i), query.offset[i], rules_of(1, false, {})).empty();
      }
      occluded[first + i] = met ? 1 : 0;
    }
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
// 3.13.5, AVX-512). Packets of 8 work, and are native wherever 16 are; without the flag 16 work too.
uint32_t occlusion_width(uint32_t native, bool coherent) {
  return coherent ? std::min(native, 8u) : native;
}

bool has_cut_outs(const TraceTable& table) {
  return std::any_of(table.instances.begin(), table.instances.end(),
                     [](const TraceInstance& i) { return i.discards && !i.material->translucent; });
}

bool same_alpha(const model::Material& a, const model::Material& b) {
  return a.without_factor_alpha == b.without_factor_alpha && a.without_vertex_alpha == b.without_vertex_alpha &&
         a.without_texel_alpha == b.without_texel_alpha;
}

// Returns whether instance `i` has the same holes in both tables, so that the same rays hit it.
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
         m.alpha_cutoff == n.alpha_cutoff && m.base_color[3] == n.base_color[3] && same_alpha(*x.material, *y.material) &&
         std::memcmp(&slot, &other, sizeof(slot)) == 0;
}

// Returns whether the holes changed in any opaque instance that both tables have. Added and removed instances are
// counted elsewhere.
bool holes_differ(const TraceTable& a, const TraceTable& b) {
  for (size_t i = 0; i < std::min(a.instances.size(), b.instances.size()); ++i) {
    const bool cut_out = (a.instances[i].discards && !a.instances[i].material->translucent) ||
                         (b.instances[i].discards && !b.instances[i].material->translucent);
    if (cut_out && !has_same_holes(a, b, i)) return true;
  }
  return false;
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
  uint64_t opaque_revision = 0;

  MaskedInstances translucent(LayerSet set) const { return {table, layers, mask_of(set)}; }
  MaskedInstances opaque(uint32_t mask) const { return {table, world, mask}; }

  // Drops both scenes, which may be half updated.
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

void Intersector::nearest_layers(LayerSet set, std::span<const Ray> rays, const LayerSearch& search, Hit* hits,
                                 uint32_t* counts) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays, meets_sprites(set));
  const LayerRules rules = rules_of(search.layers, search.cull, search.cone);
  if (rules.layers == 0 || !has_translucent(set)) {
    std::fill_n(counts, rays.size(), 0u);
    return;
  }
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->translucent(set), rules, search.coherent, rays, {hits, counts});
  });
}

void Intersector::nearest_places(LayerSet set, std::span<const Ray> rays, const LayerSearch& search, Hit* hits,
                                 uint32_t* counts, double* known) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays, meets_sprites(set));
  if (!has_translucent(set)) {
    std::fill_n(counts, rays.size(), 0u);
    std::fill_n(known, rays.size(), std::numeric_limits<double>::infinity());
    return;
  }
  const LayerRules rules{.layers = 1, .kept = most_at_place, .cull = search.cull, .cone = search.cone};
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->translucent(set), rules, search.coherent, rays, {hits, counts}, known);
  });
}

void Intersector::all_layers(LayerSet set, std::span<const Ray> rays, RaySurfaces& surfaces) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays, meets_sprites(set));
  surfaces.hits.clear();
  surfaces.ends.clear();
  if (!has_translucent(set)) {
    surfaces.ends.assign(rays.size(), 0u);
    return;
  }
  with_width(state_->width, [&](auto n) {
    gather_layers<n>(state_->translucent(set), rays, surfaces);
  });
}

void Intersector::nearest_opaque(std::span<const Ray> rays, const OpaqueSearch& search, Hit* hits) const {
  const uint32_t mask = mask_of(search.set);
  const LayerRules rules = rules_of(1, search.cull, search.cone);
  const FlushDenormals flush;
  constexpr size_t chunk = 256;
  std::array<uint32_t, chunk> counts;
  for (size_t first = 0; first < rays.size(); first += chunk) {
    const auto part = rays.subspan(first, std::min(chunk, rays.size() - first));
    with_width(state_->width, [&](auto n) {
      trace_layers<n>(state_->opaque(mask), rules, search.coherent, part, {hits + first, counts.data()});
    });
    for (size_t i = 0; i < part.size(); ++i)
      if (counts[i] == 0) hits[first + i] = {INFINITY, 0.0f, 0.0f, no_instance, 0, false};
  }
  if (Following* following = Following::now()) following->follow(rays, hits);
}

void Intersector::nearest_opaque_layers(std::span<const Ray> rays, const LayerSearch& search, Hit* hits,
                                        uint32_t* counts) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays, false);
  const LayerRules rules = rules_of(search.layers, search.cull, search.cone);
  with_width(state_->width, [&](auto n) {
    trace_layers<n>(state_->opaque(mask_opaque), rules, search.coherent, rays, {hits, counts});
  });
}

void Intersector::occluded(std::span<const Ray> rays, bool coherent, uint8_t* occluded, OpaqueSet set) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays, false);
  with_width(occlusion_width(state_->width, coherent), [&](auto n) {
    trace_occlusion<n>(state_->opaque(mask_of(set)), state_->cut_outs, coherent, {rays}, occluded);
  });
}

void Intersector::occluded(const RayColumns& rays, bool coherent, uint8_t* occluded, OpaqueSet set) const {
  const FlushDenormals flush;
  if (Following* following = Following::now()) following->follow(rays);
  with_width(occlusion_width(state_->width, coherent), [&](auto n) {
    trace_occlusion<n>(state_->opaque(mask_of(set)), state_->cut_outs, coherent, {{}, &rays}, occluded);
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
