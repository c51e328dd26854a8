#include "rt/shading/hit_shader.h"

#include <algorithm>

#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr size_t enough_rays = 1024;  // to fill packets

// Returns the base's weight for radiance from its mirror direction, as in sr_environment().
glm::vec3 base_weight(const shading::SrSurface& s, float occlusion) {
  return shading::sr_specular_albedo(s) * (s.below_sheen * (1.0f - s.coat_share) * occlusion);
}

// Returns whether a lobe is so narrow and faint that its mirror direction represents it: it has no noise, needs no
// filter, and is reused like a mirror's. Other lobes are sampled in one random direction a point, and the filter needs
// the samples of all points.
bool is_narrow(float roughness, float weight) {
  constexpr float most_roughness = 0.1f, most_weight = 0.1f;
  return roughness <= most_roughness && weight <= most_weight;
}

bool bit(uint32_t bits, size_t i) {
  return (bits >> i & 1u) != 0;
}

// Returns the weight of radiance from the base's mirror direction, plus that of a coat with the same mirror direction.
float mirror_share(const AroundBlock& a, size_t lane) {
  return a.share[lane] + (bit(a.alike, lane) ? a.coat_share[lane] : 0.0f);
}

}  // namespace

void HitShader::begin(const ShadingScene& scene, const Intersector& intersector, const HitShading& options) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = options.shadows;
  tell_rough_ = options.tell_rough;
  error_ = options.error;
  rough_.clear();
  rays_reflection = rays_shadow = rays_bounce = 0;
  bounces_ = options.bounces && !scene.snapshot->fixed;
  if (bounces_) around_.begin(scene, intersector, shadows_, *options.bounces, options.seen ? &*options.seen : nullptr);
  mirrors_.begin(scene, intersector, *this);
  light_.begin(scene, intersector);
  const std::string isa = intersector.isa();
  for (SurfaceBatch* batch : {&seen_, &reflected_, &in_front_}) {
    batch->begin(scene, isa, options.viewer);
    if (bounces_) batch->occlude_by_rays();
  }
}

void HitShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  seen_.load(points);
  trace_reflections(points);
  if (tell_rough_) collect_rough(points);
  let_arrive(seen_);
  seen_.finish(radiance);
  add_direct_seen(radiance);
  seen_.show(radiance);
}

// Adds direct light to seen_, and stores its part of write_answers().
void HitShader::add_direct_seen(glm::vec3* radiance) {
  offered_.assign(seen_.size(), glm::vec3(0.0f));
  arrived_.assign(seen_.size(), glm::vec3(0.0f));
  add_lights(seen_, radiance, {offered_.data(), arrived_.data()});
}

void HitShader::write_answers(RayAnswer* answers) const {
  for (size_t i = 0; i < offered_.size(); ++i) answers[i] = {.offered = offered_[i], .arrived = arrived_[i]};
  for (size_t r = 0; r < mirrors_.size(); ++r) {
    if (mirrors_.mirror(r).layer != 0) continue;
    RayAnswer& answer = answers[mirrors_.point(r)];
    answer.mirrored = mirrors_.radiance(r);
    answer.nearness = mirrors_.nearness(r);
    answer.has_mirror = true;
  }
}

void HitShader::consider(std::span<const SurfacePoint> points, RayProspect* prospects) {
  seen_.load(points);
  offered_.resize(points.size());
  offered_shine_.resize(points.size());
  seen_.unblocked(offered_.data(), seen_.is_separate() ? offered_shine_.data() : nullptr);
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t i = 0; i < points.size(); ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    const float share = mirror_share(a, lane);
    prospects[i] = {offered_[i], share, !mirrors(mirror_of(points[i], i, 0)) || bit(a.coated & ~a.alike, lane)};
  }
}

void HitShader::shade_reusing(std::span<const SurfacePoint> points, std::span<const ReusedRays> reused,
                              glm::vec3* radiance) {
  without_mirrors_.clear();
  for (const ReusedRays& rays : reused) without_mirrors_.push_back(!rays.traces_mirrors);
  trace_reflections(points);
  without_mirrors_.clear();
  if (tell_rough_) collect_rough(points);
  see_own_surroundings(reused);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!reused[i].has_mirror) continue;
    AroundBlock& a = seen_.around()[i / block_size];
    const size_t lane = i % block_size;
    if (reused[i].nearness > 0.0f) set_vector(a.specular, lane, reused[i].mirrored);
    const glm::vec3 mirrored = vector_at(a.specular, lane);
    if (bit(a.alike, lane)) set_vector(a.coat, lane, mirrored);
  }
  let_arrive(seen_);
  seen_.finish(radiance);
  for (size_t i = 0; i < points.size(); ++i) {
    if (seen_.is_separate()) {
      seen_.shine()[i] += offered_shine_[i] * reused[i].lit;
      offered_[i] -= offered_shine_[i];
    }
    radiance[i] += offered_[i] * reused[i].lit;
  }
  seen_.show(radiance);
}

// For points that reuse rays: uses their own environment if no donor's mirror ray hit anything.
void HitShader::see_own_surroundings(std::span<const ReusedRays> reused) {
  for (size_t first = 0; first < reused.size(); first += block_size) {
    uint32_t lanes = 0;
    for (size_t i = first; i < std::min(first + block_size, reused.size()); ++i)
      lanes |= uint32_t{reused[i].has_mirror && reused[i].nearness == 0.0f} << (i - first);
    if (lanes != 0) seen_.reflect_environment_in_base(first / block_size, lanes);
  }
}

void HitShader::shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  if (points.empty()) return;
  reflected_.load(points);
  shade_reflected(radiance);
}

// Traces rays of several lights together, because the last packet of each light would be half empty.
void HitShader::add_lights(SurfaceBatch& batch, glm::vec3* radiance, RayAnswers answers) {
  if (shadows_ && error_ > 0.0f) return add_drawn_lights(batch, radiance, answers);
  light_.clear();
  for (size_t i = 0; i < batch.lights(); ++i) {
    light_.gather(batch, i);
    if (light_.rays() < enough_rays && i + 1 < batch.lights()) continue;
    trace_lights(batch, radiance);
    if (answers.arrived) light_.tell(answers.offered, answers.arrived);
    light_.clear();
  }
}

// Does the same if faint lights are sampled at random.
void HitShader::add_drawn_lights(SurfaceBatch& batch, glm::vec3* radiance, RayAnswers answers) {
  // Fractions of `error_`, the maximum spread among donors. Lights that add more than `most` always get a ray.
  constexpr float least = 0.25f, most = 0.5f;
  const LightOdds odds{least * error_, most * error_};
  light_.clear();
  for (size_t b = 0; b < batch.blocks(); ++b) {
    light_.draw(batch, b, odds, answers.offered);
    if (light_.rays() < enough_rays && b + 1 < batch.blocks()) continue;
    trace_lights(batch, radiance);
    if (answers.arrived) light_.tell(nullptr, answers.arrived);
    light_.clear();
  }
}

void HitShader::trace_lights(SurfaceBatch& batch, glm::vec3* radiance) {
  if (shadows_) rays_shadow += light_.rays();
  light_.add(shadows_ ? intersector_ : nullptr, radiance);
  if (batch.is_separate()) light_.add_shine(batch.shine());
}

// Traces the mirror directions of seen_, and stores their radiance.
void HitShader::trace_reflections(std::span<const SurfacePoint> points) {
  collect_mirror_rays(points);
  const uint64_t before = mirrors_.traversals;
  mirrors_.follow();
  rays_reflection += mirrors_.traversals - before;
  const std::span<AroundBlock> around = seen_.around();
  for (size_t r = 0; r < mirrors_.size(); ++r) {
    AroundBlock& block = around[mirrors_.point(r) / block_size];
    const size_t lane = mirrors_.point(r) % block_size;
    const bool is_base = mirrors_.mirror(r).layer == 0;
    if (is_base) set_vector(block.specular, lane, mirrors_.radiance(r));
    if (!is_base || bit(block.alike, lane)) set_vector(block.coat, lane, mirrors_.radiance(r));
  }
}

void HitShader::collect_rough(std::span<const SurfacePoint> points) {
  rough_.assign(points.size(), RoughReflection{});
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t r = 0; r < mirrors_.size(); ++r) {
    if (mirrors(mirrors_.mirror(r))) continue;
    const uint32_t i = mirrors_.point(r);
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    const shading::SrSurface& s = points[i].surface;
    const float occlusion = bounces_ ? 1.0f : s.occlusion;
    const glm::vec3 coat(s.coat_share * occlusion);
    const glm::vec3 base = base_weight(s, occlusion);
    const bool is_coat = mirrors_.mirror(r).layer == 1;
    add_rough(r, is_coat ? coat : bit(a.alike, lane) ? base + coat : base, rough_[i]);
  }
}

// Merges a rough coat and a rough base into one lobe, with the roughness of the one that reflects more.
void HitShader::add_rough(size_t ray, glm::vec3 weight, RoughReflection& rough) const {
  const glm::vec3 both = rough.weight + weight;
  const glm::vec3 light = rough.radiance * rough.weight + mirrors_.radiance(ray) * weight;
  const float before = largest(rough.weight), now = largest(weight);
  if (now > before) rough.roughness = mirrors_.mirror(ray).roughness;
  const float nearness = mirrors_.nearness(ray);
  if (now > 0.0f)
    rough.nearness = before > 0.0f ? (rough.nearness * before + nearness * now) / (before + now) : nearness;
  for (int c = 0; c < 3; ++c) rough.radiance[c] = both[c] > 0.0f ? light[c] / both[c] : 0.0f;
  rough.weight = both;
}

Mirror HitShader::mirror_of(const SurfacePoint& point, size_t i, uint32_t layer) const {
  const AroundBlock& a = seen_.around()[i / block_size];
  const size_t lane = i % block_size;
  const shading::SrSurface& s = point.surface;
  const float share = layer == 0 ? mirror_share(a, lane) : a.coat_share[lane];
  const float cover = point.blended.cover, weight = share * point.weight;
  if (layer == 0) {
    const float roughness = shading::sr_round_roughness(s);
    const bool brushed = bit(a.brushed, lane);
    const bool narrow = (brushed || !mirrors(roughness)) && is_narrow(roughness, share * cover);
    return {vector_at(a.mirror, lane), vector_at(a.normal, lane), a.roughness[lane], 0, brushed, narrow, weight};
  }
  const bool narrow = !mirrors(s.coat_roughness) && is_narrow(s.coat_roughness, share * cover);
  return {vector_at(a.coat_mirror, lane), s.coat_normal, s.coat_roughness, 1, false, narrow, weight};
}

// Fills lobes_ with the bases', then the coats', so that neighbours in a packet have similar directions.
void HitShader::choose_lobes(size_t points) {
  lobes_.clear();
  const std::span<const AroundBlock> around = seen_.around();
  for (size_t i = 0; i < points; ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    if (mirror_share(a, lane) < least_mirror_share || reuses_mirror(i)) continue;
    lobes_.push_back({static_cast<uint32_t>(i), 0});
  }
  for (size_t i = 0; i < points; ++i) {
    const AroundBlock& a = around[i / block_size];
    const size_t lane = i % block_size;
    if (!bit(a.coated & ~a.alike, lane) || a.coat_share[lane] < least_mirror_share || reuses_mirror(i)) continue;
    lobes_.push_back({static_cast<uint32_t>(i), 1});
  }
}

void HitShader::collect_mirror_rays(std::span<const SurfacePoint> points) {
  mirrors_.clear();
  choose_lobes(points.size());
  // Rays of rough lobes have any direction and come last, because mixed packets would be slow.
  for (const bool rough : {false, true})
    for (const Lobe& lobe : lobes_) {
      const SurfacePoint& p = points[lobe.point];
      const Mirror mirror = mirror_of(p, lobe.point, lobe.layer);
      if (mirrors(mirror) == rough) continue;
      const AroundBlock& a = seen_.around()[lobe.point / block_size];
      const size_t lane = lobe.point % block_size;
      mirrors_.add(p, lobe.point, vector_at(lobe.layer == 0 ? a.mirror_origin : a.coat_origin, lane), mirror);
    }
}

std::span<const ArrivingLight> HitShader::find_arriving(const SurfaceBatch& batch, bool matt) {
  const uint64_t rays = around_.rays(), shadow = around_.rays_shadow();
  const std::span<const ArrivingLight> arriving = around_.find(batch, matt);
  rays_bounce += around_.rays() - rays;
  rays_shadow += around_.rays_shadow() - shadow;
  return arriving;
}

// If light bounces, replaces the whole sky by the light that arrives at diffuse surfaces.
void HitShader::let_arrive(SurfaceBatch& batch) {
  if (bounces_) batch.let_arrive(find_arriving(batch, true));
}

// Adds the environment to surfaces without mirror rays.
void HitShader::see_around(SurfaceBatch& batch) {
  batch.reflect_environment();
  if (!bounces_) return;
  const std::span<const ArrivingLight> arriving = find_arriving(batch, false);
  batch.let_arrive(arriving);
  batch.let_arrive_in_mirrors(arriving);
}

// Computes light without further reflections, which the prefiltered environment replaces.
void HitShader::shade_reflected(glm::vec3* radiance) {
  see_around(reflected_);
  reflected_.finish(radiance);
  add_lights(reflected_, radiance, {});
  reflected_.show(radiance);
}

void HitShader::shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) {
  if (hits.empty()) return;
  reflected_.load(hits);
  shade_reflected(radiance);
}

void HitShader::shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) {
  if (hits.empty()) return;
  in_front_.load(hits);
  in_front_.blend(hits, blends);
  see_around(in_front_);
  in_front_.finish_unblocked(radiance);
}

glm::vec3 HitShader::surroundings(glm::vec3 direction, float roughness) const {
  return environment_specular(*scene_->snapshot->environment, direction, roughness);
}

void HitShader::surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const {
  seen_.surroundings(places, radiance);
}

}  // namespace sideray::rt
