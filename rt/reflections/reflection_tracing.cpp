#include "rt/reflections/reflection_tracing.h"

#include <algorithm>
#include <cmath>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/base/half_bits.h"
#include "rt/base/sampling.h"
#include "rt/history/still_frames.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/frame_tiles.h"
#include "rt/layers/layer_tracer.h"
#include "rt/masks/depth_points.h"
#include "rt/opaque/light_tiles.h"
#include "rt/reflections/older_reflections.h"
#include "rt/shading/frame_shaders.h"
#include "rt/shading/hit_shader.h"
#include "rt/shading/host_shader.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_size = DepthPoints::tile_size;
constexpr uint32_t point_purpose = 51;
constexpr uint32_t read_around = 1;  // tiles that the filter reads around one
// Cosine between the depth's normal and the shading normal: below it, the depth's normal belongs to an edge.
constexpr float least_likeness = 0.3f;
// The roughness at which surfaces are mirrors, and its value after conversion from halfs.
constexpr float floor_of_roughness = 0.04f, mirror_roughness = 0.0401f;

static_assert(tile_size == LayerCache::tile_size);  // of tile_count()

FrameKey key_of(const ReflectionRequest& r) {
  struct Inputs {
    float max_roughness, error;
    uint32_t denoise, exact;
  };
  const Inputs inputs{r.max_roughness, r.error, r.denoise, !r.points.empty()};
  FrameKey key = frame_key(r, bytes_through(&Inputs::exact, inputs));
  key.bounces = r.light_bounces;
  return key;
}

StillFrames::Hashes hash_pictures(const ReflectionRequest& r, Executor& executor) {
  return {hash_depth(executor, r.depth, r.width, r.height, 0), hash_rows(executor, r.normals.bytes(), r.height)};
}

void check(const ReflectionRequest& r) {
  check_light(r, "reflections");
  if (r.normals.size() != size_t{r.width} * r.height)
    fail(SIDERAY_INTERNAL, "reflections: {} normals for {}x{} pixels", r.normals.size(), r.width, r.height);
  if (!(r.max_roughness >= 0.0f && r.max_roughness <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "reflection_max_roughness {}: give 0 to 1", r.max_roughness);
}

// Fills the fields of a surface that its mirror ray needs.
SurfacePoint surface_of(const ReflectionRequest& r, const ViewRays& view, const DepthPoint& p, glm::vec4 normal) {
  const Ray ray = view.ray(p.x, p.y);
  const Cone cone = view.cone(p.x, p.y);
  SurfacePoint s{};
  s.to_eye = -ray.direction;
  s.surface.normal = shading::sr_toward_eye(glm::normalize(glm::vec3(normal)), s.to_eye);
  s.position = p.front + s.surface.normal * p.skip;
  // If few pixels show the surface, or an edge runs through them, the depth gives no reliable normal: it would lift
  // mirror directions of a grazing surface into the sky.
  const bool is_edge = p.skip > 0.0f || glm::dot(p.normal, s.surface.normal) < least_likeness;
  s.geometric_normal = is_edge ? s.surface.normal : p.normal;
  s.surface.roughness = normal.w <= mirror_roughness ? floor_of_roughness : normal.w;
  s.cone = {cone.width + cone.spread * glm::dot(p.front - ray.origin, ray.direction), cone.spread};
  s.key = random_key({pixel_key(r.seed, 0, p.x, p.y), point_purpose});
  return s;
}

// Returns whether the surface is smooth there, flat or curved: normals change evenly from each pixel to the opposite one.
// Then single directions average into the lobe's light; on a bumpy surface, they would be specks.
bool is_smooth_around(const ReflectionRequest& r, size_t texel) {
  constexpr int64_t ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  const auto x = static_cast<int64_t>(texel % r.width), y = static_cast<int64_t>(texel / r.width);
  const auto normal = [&](int64_t u, int64_t v) { return glm::vec3(r.normals[static_cast<size_t>(v * r.width + u)]); };
  const glm::vec4 own = r.normals[texel];
  const float turn = own.w * own.w * share_of_lobe;
  int alike = 0, around = 0;
  for (const int64_t step : {1, 2})
    for (const auto& [i, j] : ways) {
      const int64_t u = step * i, v = step * j;
      if (x < std::abs(u) || y < std::abs(v) || x + std::abs(u) >= r.width || y + std::abs(v) >= r.height) continue;
      const glm::vec3 bend = (normal(x + u, y + v) + normal(x - u, y - v)) * 0.5f - glm::vec3(own);
      alike += glm::dot(bend, bend) < turn * turn ? 1 : 0;
      ++around;
    }
  return 2 * alike > around;
}

}  // namespace

glm::vec4 NormalTexels::operator[](size_t texel) const {
  if (!are_halfs_) return reinterpret_cast<const glm::vec4*>(bytes_.data())[texel];
  const auto* half = reinterpret_cast<const uint16_t*>(bytes_.data()) + 4 * texel;
  return {imath_half_to_float(half[0]), imath_half_to_float(half[1]), imath_half_to_float(half[2]), imath_half_to_float(half[3])};
}

float NormalTexels::roughness(size_t texel) const {
  const size_t w = 4 * texel + 3;
  return are_halfs_ ? imath_half_to_float(reinterpret_cast<const uint16_t*>(bytes_.data())[w])
                    : reinterpret_cast<const float*>(bytes_.data())[w];
}

// The loops have no branches, so that they become vector code. Halfs of one sign are ordered like their bits.
bool NormalTexels::find_reflecting(size_t first, size_t count, float max_roughness, uint8_t* reflects) const {
  uint8_t any = 0;
  if (are_halfs_) {
    const auto* half = reinterpret_cast<const uint16_t*>(bytes_.data()) + 4 * first + 3;
    auto most = static_cast<int16_t>(half_bits(max_roughness) + 1);
    while (most >= 0 && !(reflection_share(imath_half_to_float(static_cast<uint16_t>(most)), max_roughness) > 0.0f)) --most;
    for (size_t i = 0; i < count; ++i) any |= reflects[i] = static_cast<int16_t>(half[4 * i]) <= most;
  } else {
    const float* value = reinterpret_cast<const float*>(bytes_.data()) + 4 * first + 3;
    for (size_t i = 0; i < count; ++i) any |= reflects[i] = reflection_share(value[4 * i], max_roughness) > 0.0f;
  }
  return any != 0;
}

float reflection_share(float roughness, float max_roughness) {
  if (!(roughness <= max_roughness)) return 0.0f;
  if (roughness <= mirror_roughness) return 1.0f;
  return std::min(3.0f * (1.0f - roughness / max_roughness), 1.0f);
}

struct ReflectionTracing::Worker {
  DepthPoints depth_points;
  HitShader built_in;
  HostShader host;
  MirrorRays mirrors;
  std::vector<RoughReflection> rough;
  std::vector<SurfacePoint> points;
  std::vector<uint32_t> texels;
  std::vector<glm::vec3> radiance;
  Counters counters;
};

// Returns false if no pixel of the tile reflects.
bool ReflectionTracing::gather(const Tile& tile, Worker& w) {
  const ReflectionRequest& r = *tile.request;
  const auto share = [&](uint32_t x, uint32_t y) {
    const size_t texel = size_t{y} * r.width + x;
    const float traced = reflection_share(r.normals.roughness(texel), r.max_roughness);
    if (!(traced > 0.0f)) return 0.0f;
    const glm::vec3 n(r.normals[texel]);
    return glm::dot(n, n) > 0.0f ? traced : 0.0f;
  };
  bool any = false;
  for (uint32_t y = tile.y; y < std::min(tile.y + tile_size, r.height) && !any; ++y)
    for (uint32_t x = tile.x; x < std::min(tile.x + tile_size, r.width) && !any; ++x) any = share(x, y) > 0.0f;
  w.points.clear(), w.texels.clear();
  if (!any) return false;
  const PointTile& points = w.depth_points.gather(depth_request(r), *tile.view, tile.x, tile.y);
  for_each_pixel(points.drawn, [&](uint32_t pixel) {
    const uint32_t x = tile.x + column_in_tile(pixel), y = tile.y + row_in_tile(pixel);
    if (share(x, y) <= 0.0f) return;
    const size_t texel = size_t{y} * r.width + x;
    w.points.push_back(surface_of(r, *tile.view, point_at(points, pixel), r.normals[texel]));
    w.texels.push_back(static_cast<uint32_t>(texel));
  });
  return !w.points.empty();
}

// Fills radiance, and rough if rough lobes are filtered.
TraceEnd ReflectionTracing::reflect(const Tile& tile, Worker& w) {
  const ReflectionRequest& r = *tile.request;
  const bool by_host = tile.scene->snapshot->shader.shade != nullptr;
  if (by_host)
    w.host.begin(*tile.scene, *tile.intersector, host_calls(r), r.shadows);
  else
    w.built_in.begin(*tile.scene, *tile.intersector,
                     {.shadows = r.shadows, .error = r.error, .viewer = way_to_viewer(r.view), .bounces = bounces_of(r)});
  w.mirrors.begin(*tile.scene, *tile.intersector,
                  by_host ? static_cast<SecondaryHitShader&>(w.host) : static_cast<SecondaryHitShader&>(w.built_in));
  w.radiance.resize(w.points.size());
  w.rough.clear();
  w.mirrors.reflect(w.points, w.radiance.data(), r.denoise ? &w.rough : nullptr);
  if (by_host && w.host.end != TraceEnd::complete) return w.host.end;
  w.counters.rays_reflection += w.mirrors.traversals;
  add_work(by_host ? static_cast<ShaderWork&>(w.host) : static_cast<ShaderWork&>(w.built_in), {}, w.counters);
  return TraceEnd::complete;
}

void ReflectionTracing::empty(const Tile& tile, ReflectionImage& image) {
  const ReflectionRequest& r = *tile.request;
  for (uint32_t y = tile.y; y < std::min(tile.y + tile_size, r.height); ++y)
    std::fill_n(&image.radiance[4 * (size_t{y} * r.width + tile.x)], 4 * std::min(tile_size, r.width - tile.x), uint16_t{0});
}

void ReflectionTracing::trace_tile(const Tile& tile, Worker& w, ReflectionImage& image) {
  if (!gather(tile, w) || reflect(tile, w) != TraceEnd::complete) return;
  for (size_t i = 0; i < w.points.size(); ++i) {
    store_rgba(&image.radiance[4 * size_t{w.texels[i]}], w.radiance[i], 1.0f);
    if (w.rough.empty() || w.rough[i].weight == glm::vec3(0.0f)) continue;
    RoughReflection& rough = w.rough[i];
    if (!is_smooth_around(*tile.request, w.texels[i])) {
      rough.radiance = w.radiance[i];
      rough.is_sampled = false;
    }
    // Surfaces are distinguished by position and normal, because the depth buffer has no ids.
    filter_.chunk(tile.index).add(w.texels[i], w.texels[i], 1, w.points[i], w.radiance[i], rough);
  }
}

ReflectionTracing::ReflectionTracing(uint32_t threads) : workers_(threads) {}
ReflectionTracing::~ReflectionTracing() = default;

Counters ReflectionTracing::trace(const ReflectionRequest& r, TracedScene& scene, ReflectionImage& image) {
  check(r);
  image.changed = !(r.still && r.still->begin(key_of(r), r.sequence, scene.committed(),
                                              [&] { return hash_pictures(r, scene.executor()); }) &&
                    image.width == r.width && image.height == r.height);
  if (!image.changed) return r.still->counters();
  const std::vector<uint8_t> traced = traced_tiles(r.wanted, r.width, read_around);
  const bool all = traced.empty();
  OlderReflections* older = is_bounded(r.work) ? r.older : nullptr;
  if (r.older && !older) r.older->forget();
  const bool is_new = image.width != r.width || image.height != r.height;
  image.width = r.width;
  image.height = r.height;
  if (older) {
    older->begin(r, scene, image);
  } else if (all || is_new) {
    image.radiance.assign(size_t{4} * r.width * r.height, 0);
  } else {
    for_tile_rows(r.width, r.height, traced, scene.executor(), [&](size_t first, uint32_t count) {
      std::fill_n(image.radiance.begin() + static_cast<ptrdiff_t>(4 * first), 4 * size_t{count}, uint16_t{0});
    });
  }
  Counters counters = trace_tiles(r, scene, traced, older, image);
  if (older && !(r.cancelled && r.cancelled->load())) older->end();
  const Stopwatch watch;
  if (r.denoise) {
    filter(r, scene.executor(), image);
    counters.denoise_ms = watch.ms();
  }
  scene.executor().run(r.height, [&](size_t y, uint32_t) {
    for (size_t texel = y * r.width; texel < (y + 1) * r.width; ++texel)
      if (image.radiance[4 * texel + 3] != 0)
        image.radiance[4 * texel + 3] = half_bits(reflection_share(r.normals.roughness(texel), r.max_roughness));
  });
  if (r.still) r.still->end(counters, !is_bounded(r.work) && all);
  return counters;
}

Counters ReflectionTracing::trace_tiles(const ReflectionRequest& r, TracedScene& scene,
                                        const std::vector<uint8_t>& traced, OlderReflections* older,
                                        ReflectionImage& image) {
  const ShadingScene& shading = scene.shading();
  const ViewRays view(r.view, r.width, r.height);
  const uint32_t columns = tile_count(r.width);
  for (Worker& worker : workers_) worker.counters = {};
  filter_.begin(size_t{columns} * tile_count(r.height));
  const std::span<const uint32_t> turns = older ? std::span(older->turns()) : std::span<const uint32_t>();
  for_light_tiles(
      {r, r.work, light_tile_order(r, turns), traced}, scene.executor(), [](uint32_t, uint32_t) {},
      [&](uint32_t i, uint32_t thread) {
        const Tile tile{&r, &view, &shading, &scene.intersector(), i, i % columns * tile_size, i / columns * tile_size};
        if (older) empty(tile, image);
        trace_tile(tile, workers_[thread], image);
      },
      [&](uint32_t i, uint32_t thread, bool is_traced) {
        if (older && is_traced) older->traced(i);
        if (older && !is_traced) older->leave(r, i, image, workers_[thread].counters);
      });
  Counters sum;
  for (const Worker& worker : workers_) sum += worker.counters;
  sum.pixels_total = uint64_t{r.width} * r.height;
  return sum;
}

void ReflectionTracing::filter(const ReflectionRequest& r, Executor& executor, ReflectionImage& image) {
  LayerCache cache;  // of one layer, in the filter's format
  cache.width = r.width;
  cache.height = r.height;
  cache.layers = 1;
  cache.radiance = std::move(image.radiance);
  filter_.apply(executor, cache);
  image.radiance = std::move(cache.radiance);
}

}  // namespace sideray::rt
