#include "rt/reference/path_shader.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/sampling.h"
#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

// This share of the way to a light is not tested, so that rounding does not carry the ray past it.
constexpr float short_of_light = 1e-5f;
// The same for a surface that shines, which would block its own light.
constexpr float short_of_emitter = 1e-3f;
// Some paths never leave a solid: after so many surfaces one of ten ends at each, and the others count for it; and none
// meets more than so many.
constexpr uint32_t patient_events = 64, most_events = 1024;
constexpr float patience = 0.9f;
// From this bounce on, paths that carry little end by Russian roulette, and the others count for them.
constexpr uint32_t first_roulette = 4;
constexpr float most_survival = 0.95f, least_survival = 0.05f;
// A translucent surface is reflected by and passed with this chance at least, where it does both.
constexpr float least_chance = 0.1f;
// What a beam or path carries is nothing below this share.
constexpr float least_share = 1e-7f;
// This share of the directions in which wide lobes reflect is sampled toward what stands around lamps.
constexpr float most_guided = 0.3f;

// These are the purposes of random numbers at a surface; lights count from the last one on.
enum Purpose : uint32_t { for_lobes, for_sky, for_emitter, for_choice, for_scattering, for_roulette, for_passage, for_dispersion, for_lights };

bool is_finite(glm::vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::vec3 start_of_ray(const SurfacePoint& p, glm::vec3 direction) {
  const float side = glm::dot(p.geometric_normal, direction) < 0.0f ? -p.offset : p.offset;
  return p.position + p.geometric_normal * side;
}

// Returns what of the light a path counts for, where samples of the other density find it too (balance heuristic).
float share_of_path(float density, float other) {
  return density > 0.0f && other > 0.0f ? density * balance(1.0f, density, 1.0f, other) : 1.0f;
}

// Light that is reflected leaves the surface on the viewer's side, however far the shading normal is bent.
glm::vec3 leaving(const SurfacePoint& p, glm::vec3 direction) {
  return glm::dot(p.surface.normal, direction) > 0.0f ? shading::sr_lifted(direction, p.geometric_normal) : direction;
}

// The same surface is lit anew at every bounce: the point's own numbers tell one path's bounces apart.
uint32_t stratum(uint32_t key, uint32_t purpose, uint32_t half, uint32_t bounce) {
  return random_key({key, purpose, half, bounce});
}

}  // namespace

void PathShader::begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
                       const PathSettings& settings) {
  scene_ = scene;
  emitters_ = &emitters;
  settings_ = settings;
  ways_.begin(*scene.scene, *scene.intersector, refraction);
  media_ = nullptr;
  rays_reflection = rays_shadow = 0;
}

glm::vec3 PathShader::surroundings(glm::vec3 direction, float roughness) const {
  return environment_specular(*scene_.scene->snapshot->environment, direction, roughness);
}

void PathShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  points_ = points;
  lobes_.clear();
  lobes_.reserve(points.size());
  sums_.clear();
  for (const SurfacePoint& p : points) {
    lobes_.emplace_back(p);
    sums_.push_back(shading::sr_emitted(p.surface));
  }
  add_exact_lights(points);
  for (size_t i = 0; i < points.size(); ++i) radiance[2 * i] = radiance[2 * i + 1] = sums_[i];
  for (uint32_t half = 0; half < 2; ++half) {
    const uint32_t samples = (settings_.samples + 1 - half) / 2;
    if (samples == 0) break;
    std::fill(sums_.begin(), sums_.end(), glm::vec3(0.0f));
    for (uint32_t j = 0; j < samples; ++j) {
      drawing_ = {half, j};
      trace_paths(points);
    }
    for (size_t i = 0; i < points.size(); ++i) radiance[2 * i + half] += sums_[i] / static_cast<float>(samples);
  }
  if (settings_.samples == 1)
    for (size_t i = 0; i < points.size(); ++i) radiance[2 * i + 1] = radiance[2 * i];
  media_ = nullptr;
}

// Adds what lights without a size do directly, for which one ray is exact.
void PathShader::add_exact_lights(std::span<const SurfacePoint> points) {
  for (const ReferenceLight& light : *scene_.lights) {
    if (light.sized()) continue;
    for (uint32_t i = 0; i < points.size(); ++i) {
      const SurfacePoint& p = points[i];
      const shading::SrIncidence in = shading::sr_incidence(light.light, p.position);
      const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
      const Path path = path_of(p, i);
      add_beam(path, beam_from(path, p, in.to_light, in.distance), gain, gain, Target::lamp);
    }
    end_beams();
  }
}

void PathShader::trace_paths(std::span<const SurfacePoint> points) {
  next_paths_.clear();
  for (uint32_t i = 0; i < points.size(); ++i)
    if (lobes_[i].reflects()) {
      Path path = path_of(points[i], i);
      bounce(path, points[i], lobes_[i]);
    }
  end_beams();
  while (!next_paths_.empty()) {
    std::swap(paths_, next_paths_);
    next_paths_.clear();
    group_.clear();
    for (Path& path : paths_) group_.push_back(&path.way);
    const uint64_t before = ways_.traversals;
    ways_.find_opaque(group_);
    ways_.find_translucent(group_);
    rays_reflection += ways_.traversals - before;
    for (Path& path : paths_) advance(path);
    end_beams();
  }
}

PathShader::Path PathShader::path_of(const SurfacePoint& p, uint32_t index) const {
  const uint32_t key = random_key({p.key, drawing_.half, drawing_.sample});
  return {LightWay(p.position, -p.to_eye, 0.0f, p.cone, media_of(index)), index, key, 0, 0, glm::vec3(1.0f), 0.0f, {},
          glm::vec3(1.0f)};
}

// Follows the path as far as its surfaces are known.
void PathShader::advance(Path& path) {
  WayEvent event;
  while (ways_.next(path.way, event))
    if (!meet(path, event)) return;
  if (path.way.ahead.complete())
    end(path);
  else
    next_paths_.push_back(path);
}

// Lets the path meet a translucent surface. Returns whether it goes on along the same ray; where it goes on otherwise, it is
// among the next paths.
bool PathShader::meet(Path& path, WayEvent& event) {
  path.weight *= event.arriving;
  if (++path.events > most_events) return false;
  event.point.key = random_key({path.key, path.events});
  if (path.events > patient_events) {
    if (unit_float(random_key({event.point.key, for_roulette})) >= patience) return false;
    path.weight /= patience;
  }
  if (event.passage == Passage::mirrored) {
    bend(path, event, event.direction);
    return false;
  }
  const shading::SrBlend& blend = event.point.blended;
  const glm::vec3 emitted = shading::sr_emitted(event.point.surface);
  if (emitted != glm::vec3(0.0f)) sums_[path.point] += path.weight * blend.cover * emitted * counted(path, event.point.hit);
  const LobeSampler lobes(event.point);
  const float reflects = may_bounce(path) && lobes.reflects() ? blend.cover * lobes.albedo() : 0.0f;
  const float passes = largest(blend.through);
  if (!(reflects + passes > 0.0f)) return false;
  float chance = reflects / (reflects + passes);
  if (reflects > 0.0f && passes > 0.0f) chance = std::clamp(chance, least_chance, 1.0f - least_chance);
  if (unit_float(random_key({event.point.key, for_passage})) < chance) {
    path.weight *= blend.cover / chance;
    bounce(path, event.point, lobes);
    return false;
  }
  path.weight *= blend.through / (1.0f - chance);
  if (!(largest(path.weight) > least_share) || !is_finite(path.weight)) return false;
  if (event.passage == Passage::straight) {
    path.way.media = event.behind;
    return true;
  }
  if (event.passage == Passage::refracted && event.crossing.disperses) {
    // One channel by lot counts for all three.
    const auto lot = static_cast<uint32_t>(3.0f * unit_float(random_key({event.point.key, for_dispersion})));
    const Light light = std::array{Light::red, Light::green, Light::blue}[std::min(lot, 2u)];
    path.weight *= 3.0f * channels_of(light);
    ways_.disperse(path.way, event, light);
  }
  bend(path, event,
       event.passage != Passage::scattered
           ? event.direction
           : scattered_direction(event.point, event.crossing, random_key({event.point.key, for_scattering})));
  return false;
}

// Sends the path on in another direction. Nothing but paths finds what they meet then: it counts in full.
void PathShader::bend(Path& path, const WayEvent& event, glm::vec3 direction) {
  ways_.redirect(path.way, event, direction);
  path.density = 0.0f;
  meet_lights_bent(path, event.point);
  next_paths_.push_back(path);
}

// Returns what counts of the light of a shining surface that the path hits: it is sampled too.
glm::vec3 PathShader::counted(const Path& path, const Hit& hit) const {
  if (path.density > 0.0f)
    return glm::vec3(share_of_path(path.density, emitters_->density(path.from, hit, path.way.ray.direction)));
  return path.way.bent && emitters_->samples(hit) ? path.bent_share : glm::vec3(1.0f);
}

// Lets the path meet the opaque surface at the end of its ray, or the environment.
void PathShader::end(Path& path) {
  if (path.way.opaque.instance == no_instance) {
    if (scene_.environment->black()) return;
    path.weight *= ways_.arriving(path.way, farthest);
    const glm::vec3 direction = path.way.ray.direction;
    const float share = share_of_path(path.density, path.density > 0.0f ? scene_.environment->density(direction) : 0.0f);
    sums_[path.point] += path.weight * share * scene_.environment->radiance(direction);
    return;
  }
  path.weight *= ways_.arriving(path.way, static_cast<float>(path.way.opaque.distance));
  SurfacePoint point = ways_.end_point(path.way);
  if (++path.events > most_events) return;
  point.key = random_key({path.key, path.events});
  const glm::vec3 emitted = shading::sr_emitted(point.surface);
  if (emitted != glm::vec3(0.0f)) {
    sums_[path.point] += path.weight * emitted * counted(path, path.way.opaque);
  }
  if (!may_bounce(path)) return;
  const LobeSampler lobes(point);
  if (lobes.reflects()) bounce(path, point, lobes);
}

// Lets a surface reflect: adds the light that arrives there straight from lights and environment, and sends the path on.
void PathShader::bounce(Path& path, const SurfacePoint& point, const LobeSampler& lobes) {
  const bool is_first = path.bounces++ == 0;
  path.from = {point.position, point.surface.normal, point.surface.behind != glm::vec3(0.0f)};
  find_lights(point, is_first);
  guided_ = guide_.empty() ? 0.0f : most_guided * lobes.wide_share();
  sample_lights(path, point, lobes, is_first);
  if (!scene_.environment->black()) sample_sky(path, point, lobes);
  if (!emitters_->empty()) sample_emitter(path, point, lobes);
  if (leave(path, point, lobes)) next_paths_.push_back(path);
}

// Sends the path out of a surface that reflects. Returns false where it ends there.
bool PathShader::leave(Path& path, const SurfacePoint& point, const LobeSampler& lobes) {
  glm::vec2 u = random_point(path, for_lobes);
  const bool is_guided = u.x < guided_;
  u.x = std::min(is_guided ? u.x / guided_ : (u.x - guided_) / (1.0f - guided_), 0x1.fffffep-1f);
  const glm::vec3 direction = is_guided ? guide_.sample(u) : lobes.sample(u);
  const float density = direction == glm::vec3(0.0f) ? 0.0f : this->density(lobes, direction);
  if (!(density > 0.0f)) return false;
  const shading::SrReflection reflected = shading::sr_reflection(point.surface, point.to_eye, direction);
  const glm::vec3 all = reflected.wide + reflected.glossy;
  if (!settings_.caustics)
    for (int c = 0; c < 3; ++c) path.bent_share[c] = all[c] > 0.0f ? reflected.glossy[c] / all[c] : 0.0f;
  path.weight *= all / density;
  if (!(largest(path.weight) > 0.0f) || !is_finite(path.weight)) return false;
  meet_lights(path, point, direction, density);
  if (path.bounces >= first_roulette) {
    const float survival = std::clamp(largest(path.weight), least_survival, most_survival);
    if (unit_float(random_key({point.key, for_roulette})) >= survival) return false;
    path.weight /= survival;
  }
  path.density = density;
  const Light light = path.way.light;
  path.way = beam_from(path, point, leaving(point, direction), farthest);
  path.way.light = light;
  return true;
}

// Returns the density of a direction in which the point that reflects now sends paths.
float PathShader::density(const LobeSampler& lobes, glm::vec3 direction) const {
  const float own = lobes.density(direction);
  return guided_ > 0.0f ? (1.0f - guided_) * own + guided_ * guide_.density(direction) : own;
}

// Finds the lights that reach a point, as far as nothing is in their way. Of `all` each is sampled but those that are added
// exactly; else one is chosen, in proportion to its irradiance.
void PathShader::find_lights(const SurfacePoint& p, bool all) {
  lit_.clear();
  guide_.clear();
  float sum = 0.0f;
  for (const ReferenceLight& light : *scene_.lights) {
    LitBy lit{&light, {}, shading::sr_incidence(light.light, p.position), 1.0f};
    guide_.add(light, lit.incidence);
    if (all && !light.sized()) continue;
    const float irradiance = largest(lit.incidence.irradiance);
    if (!(irradiance > 0.0f)) continue;
    if (light.sized()) lit.cone = light_cone(light, p.position);
    if (!all) sum += lit.chance = irradiance;
    lit_.push_back(lit);
  }
  if (!all)
    for (LitBy& lit : lit_) lit.chance /= sum;
}

void PathShader::sample_lights(const Path& path, const SurfacePoint& p, const LobeSampler& lobes, bool all) {
  if (lit_.empty()) return;
  if (all) {
    for (size_t i = 0; i < lit_.size(); ++i)
      sample_light(path, p, lobes, lit_[i], for_lights + static_cast<uint32_t>(i));
    return;
  }
  float u = random_point(path, for_choice).x;
  size_t chosen = 0;
  while (chosen + 1 < lit_.size() && u >= lit_[chosen].chance) u -= lit_[chosen++].chance;
  if (lit_[chosen].chance > 0.0f) sample_light(path, p, lobes, lit_[chosen], for_lights);
}

void PathShader::sample_light(const Path& path, const SurfacePoint& p, const LobeSampler& lobes, const LitBy& lit,
                              uint32_t purpose) {
  if (!lit.light->sized()) {
    const shading::SrIncidence& in = lit.incidence;
    const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance / lit.chance;
    return add_beam(path, beam_from(path, p, in.to_light, in.distance), path.weight * gain, path.weight * gain,
                    Target::lamp);
  }
  const glm::vec2 u = random_point(path, purpose);
  const glm::vec3 direction = glm::normalize(model::Frame(lit.cone.axis).world(sample_cone(u, lit.cone.aperture)));
  const float weight =
      balance(1.0f, lit.chance / cone_solid_angle(lit.cone.aperture), 1.0f, density(lobes, direction));
  const glm::vec3 gain =
      path.weight * shading::sr_reflect_light(p.surface, p.to_eye, direction) * lit.cone.radiance * weight;
  const float distance = distance_to_light(lit.cone, u.x * lit.cone.aperture);
  add_beam(path, beam_from(path, p, direction, distance), gain, is_found(*lit.light) ? glm::vec3(0.0f) : gain,
           Target::lamp);
}

void PathShader::sample_sky(const Path& path, const SurfacePoint& p, const LobeSampler& lobes) {
  const EnvironmentSampler::Sample s = scene_.environment->sample(random_point(path, for_sky));
  const float weight = balance(1.0f, density(lobes, s.direction), 1.0f, s.density);
  const glm::vec3 gain = shading::sr_reflect_light(p.surface, p.to_eye, s.direction) *
                         scene_.environment->radiance(s.direction) * weight;
  add_beam(path, beam_from(path, p, leaving(p, s.direction), farthest), path.weight * gain, glm::vec3(0.0f), Target::scene);
}

// Adds the light of a surface that shines, sampled on it.
void PathShader::sample_emitter(const Path& path, const SurfacePoint& p, const LobeSampler& lobes) {
  const EmitterSampler::Sample s =
      emitters_->sample(path.from, random_point(path, for_choice).y, random_point(path, for_emitter));
  if (!(s.density > 0.0f)) return;
  const glm::vec3 direction = s.ray.direction;
  const shading::SrReflection reflected = shading::sr_reflection(p.surface, p.to_eye, direction);
  const glm::vec3 all = reflected.wide + reflected.glossy;
  if (!(largest(all) > 0.0f)) return;
  const SurfacePoint shining = surface_point(*scene_.scene, s.hit, s.ray, p.cone);
  glm::vec3 light = path.weight * shading::sr_emitted(shining.surface);
  if (scene_.scene->snapshot->materials[scene_.scene->snapshot->instances[s.hit.instance].material].translucent)
    light *= shining.blended.cover;
  const float distance = s.ray.t_far * (1.0f - short_of_emitter);
  const glm::vec3 gain = all * light * balance(1.0f, density(lobes, direction), 1.0f, s.density);
  const glm::vec3 bent_gain = settings_.caustics ? glm::vec3(0.0f) : reflected.wide * light / s.density;
  add_beam(path, beam_from(path, p, direction, distance), gain, bent_gain, Target::scene);
}

// Adds the lights with sizes that a path is reflected toward, which samples of the lights find too. `density`: that of the
// direction; the path's weight holds what the surface reflects already.
void PathShader::meet_lights(const Path& path, const SurfacePoint& p, glm::vec3 direction, float density) {
  for (const LitBy& lit : lit_) {
    const LightCone& cone = lit.cone;
    const float below = cone.aperture > 0.0f ? below_axis(cone, direction) : 1.0f;
    if (below >= cone.aperture || !(largest(cone.radiance) > 0.0f)) continue;
    const float weight = density * balance(1.0f, density, 1.0f, lit.chance / cone_solid_angle(cone.aperture));
    const glm::vec3 gain = path.weight * cone.radiance * weight;
    add_beam(path, beam_from(path, p, direction, distance_to_light(cone, below)), gain,
             is_found(*lit.light) ? glm::vec3(0.0f) : gain, Target::lamp);
  }
}

// Adds those that a path was bent toward by a surface.
void PathShader::meet_lights_bent(const Path& path, const SurfacePoint& p) {
  const glm::vec3 direction = path.way.ray.direction;
  for (const ReferenceLight& light : *scene_.lights) {
    if (!is_found(light)) continue;
    const LightCone cone = light_cone(light, p.position);
    const float below = below_axis(cone, direction);
    if (below >= cone.aperture || !(largest(cone.radiance) > 0.0f)) continue;
    LightWay way = path.way;
    way.ray.t_far = distance_to_light(cone, below);
    add_beam(path, way, path.weight * cone.radiance, glm::vec3(0.0f), Target::lamp);
  }
}

// Returns the way of light that a surface reflects or lets through by itself: on the far side it is in the media there.
LightWay PathShader::beam_from(const Path& path, const SurfacePoint& p, glm::vec3 direction, float length) const {
  const bool is_near = glm::dot(p.geometric_normal, direction) >= 0.0f;
  return {start_of_ray(p, direction), direction, length, p.cone,
          is_near ? path.way.media : ways_.behind(p, path.way.media)};
}

void PathShader::add_beam(const Path& path, const LightWay& way, glm::vec3 gain, glm::vec3 bent_gain, Target target) {
  if (!(largest(gain) > 0.0f || largest(bent_gain) > 0.0f) || !is_finite(gain) || !is_finite(bent_gain)) return;
  if (!settings_.shadows && target == Target::lamp) {
    sums_[path.point] += gain;
    return;
  }
  std::vector<Beam>& beams = target == Target::scene ? scene_beams_ : light_beams_;
  beams.push_back({way, path.point, gain, bent_gain, false});
  LightWay& own = beams.back().way;
  own.ray.t_far *= 1.0f - short_of_light;
  own.straight = largest(bent_gain) > 0.0f;
  own.to_lamp = target == Target::lamp;
}

// The environment is occluded by what paths meet, so that both ways to sample it see the same.
void PathShader::end_beams() {
  end_beams(light_beams_, OpaqueSet::casts_shadow);
  end_beams(scene_beams_, OpaqueSet::visible_in_reflection);
}

void PathShader::end_beams(std::vector<Beam>& beams, OpaqueSet blockers) {
  if (beams.empty()) return;
  rays_.clear();
  for (const Beam& beam : beams) {
    rays_.push_back(beam.way.ray);
    rays_.back().t_near = 0.0f;  // from before a surface that was crossed: an opaque one may lie on it
  }
  blocked_.resize(rays_.size());
  scene_.intersector->occluded(rays_, directions_agree(rays_), blocked_.data(), blockers);
  rays_shadow += rays_.size();
  size_t left = 0;
  for (size_t i = 0; i < beams.size(); ++i)
    if (!blocked_[i]) beams[left++] = beams[i];
  beams.erase(beams.begin() + static_cast<std::ptrdiff_t>(left), beams.end());
  pass_translucent(beams);
  for (const Beam& beam : beams) sums_[beam.point] += beam.gain;
  beams.clear();
}

// Takes from each beam what translucent surfaces and media on its way keep.
void PathShader::pass_translucent(std::vector<Beam>& beams) {
  const uint64_t before = ways_.traversals;
  for (;;) {
    group_.clear();
    for (Beam& beam : beams)
      if (!beam.way.ahead.complete()) group_.push_back(&beam.way);
    if (group_.empty()) break;
    ways_.find_translucent(group_);
    for (Beam& beam : beams)
      while (dims(beam)) {}
  }
  for (Beam& beam : beams) beam.gain *= ways_.arriving(beam.way, beam.way.ray.t_far);
  rays_shadow += ways_.traversals - before;
}

// Takes what the beam's next surface keeps. Returns whether there may be a further one at hand.
bool PathShader::dims(Beam& beam) {
  WayEvent event;
  if (!ways_.next(beam.way, event)) return false;
  const glm::vec3 left = event.arriving * event.point.blended.through;
  beam.gain *= left, beam.bent_gain *= left;
  if (event.passage != Passage::straight) beam.is_bent = true;
  if (beam.is_bent) beam.gain = beam.bent_gain;  // it goes straight on, or there is nothing left: paths find the light
  if (!(largest(beam.gain) > 0.0f)) {
    beam.gain = beam.bent_gain = glm::vec3(0.0f);
    beam.way.ahead.end();
    return false;
  }
  beam.way.media = event.behind;
  return true;
}

glm::vec2 PathShader::random_point(const Path& path, uint32_t purpose) const {
  return PointSet(stratum(points_[path.point].key, purpose, drawing_.half, path.bounces))[drawing_.sample];
}

}  // namespace sideray::rt
