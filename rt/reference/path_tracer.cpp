#include "rt/reference/path_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/sampling.h"
#include "rt/base/largest.h"

namespace sideray::rt {
namespace {

// Number of paths that travel together; those of one start always do.
constexpr uint32_t paths_at_once = 2048;
// Rays stop before the light by this share of the distance, so that rounding does not carry them past it.
constexpr float short_of_light = 1e-5f;
// The same for an emissive surface, which would block its own light.
constexpr float short_of_emitter = 1e-3f;
// Some paths never leave a solid. From patient_events on, a path ends at each surface with a probability of 1 in 10,
// and the survivors get its weight; no path hits more than most_events surfaces.
constexpr uint32_t patient_events = 64, most_events = 1024;
constexpr float patience = 0.9f;
// From this bounce on, paths with little weight end by Russian roulette, and the survivors get their weight.
constexpr uint32_t first_roulette = 2;
constexpr float most_survival = 0.95f, least_survival = 0.05f;
// If a surface both reflects and transmits, each is chosen with at least this probability.
constexpr float least_chance = 0.1f;
// A path with less weight counts as black.
constexpr float least_share = 1e-7f;
// The share of directions from wide lobes that is sampled toward the surroundings of lamps.
constexpr float most_guided = 0.3f;
// Number of lights sampled where a path begins, and at later surfaces.
constexpr uint32_t first_draws = 1, later_draws = 1;
// A light's contribution is estimated as at least this share of its best direction, because lobes and lights are wide.
constexpr float least_lit = 0.05f;

// The purposes of random numbers at a surface; sampled lights count from the last one on.
enum Purpose : uint32_t { for_lobes, for_sky, for_emitter, for_choice, for_scattering, for_roulette, for_passage, for_dispersion, for_lights };

bool is_finite(glm::vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::vec3 start_of_ray(const SurfacePoint& p, glm::vec3 direction) {
  const float side = glm::dot(p.geometric_normal, direction) < 0.0f ? -p.offset : p.offset;
  return p.position + p.geometric_normal * side;
}

// Returns the balance heuristic's weight of a path whose light is also sampled with the other density.
float share_of_path(float density, float other) {
  return density > 0.0f && other > 0.0f ? density * balance(1.0f, density, 1.0f, other) : 1.0f;
}

// Returns the direction, lifted to the viewer's side: reflected light leaves there, however far the shading normal is
// perturbed.
glm::vec3 leaving(const SurfacePoint& p, glm::vec3 direction) {
  return glm::dot(p.surface.normal, direction) > 0.0f ? shading::sr_lifted(direction, p.geometric_normal) : direction;
}

}  // namespace

void PathTracer::begin(const ReferenceScene& scene, const RefractionScene* refraction, const EmitterSampler& emitters,
                       const PathSettings& settings) {
  scene_ = scene;
  emitters_ = &emitters;
  settings_ = settings;
  ways_.begin(*scene.scene, *scene.intersector, refraction);
  beams_.begin(*scene.scene, *scene.intersector, refraction);
  rays_reflection = 0;
}

void PathTracer::trace(std::span<const PathStart> starts, std::span<PathSum> sums) {
  sums_ = sums;
  next_paths_.clear();
  for (const PathStart& s : starts) {
    if (next_paths_.size() + s.count > paths_at_once) follow();
    start(s);
  }
  follow();
}

void PathTracer::add_exact_lights(const PathStart& start, std::span<PathSum> sums) {
  sums_ = sums;
  const SurfacePoint& p = *start.point;
  for (const ReferenceLight& light : *scene_.lights) {
    if (light.sized()) continue;
    const shading::SrIncidence in = shading::sr_incidence(light.light, p.position);
    if (!(largest(in.irradiance) > 0.0f)) continue;
    const glm::vec3 gain = start.weight * shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
    send({{start_of_ray(p, in.to_light), 0.0f, in.to_light, in.distance}, media_on(*start.way, p, in.to_light), start.sum, {}, {}},
         gain, gain, BeamTarget::lamp);
  }
  if (beams_.size() > paths_at_once) end_beams();
}

// Starts the paths.
void PathTracer::start(const PathStart& start) {
  if (start.count == 0) return;
  const LobeSampler lobes(*start.point);
  if (!start.passed) {
    if (!lobes.reflects()) return;
    find_lights(*start.point, lobes, true);
  }
  for (uint32_t i = 0; i < start.count; ++i) {
    const uint32_t number = start.first + i;
    Path path{*start.way, start.sum, start.key, number, random_key({start.key, number}), 0, 0, start.weight,
              largest(start.weight), 0.0f, {}, glm::vec3(1.0f)};
    if (start.passed) {
      WayEvent event = *start.passed;
      event.point.key = random_key({path.key, path.events});
      pass(path, event);
      continue;
    }
    path.usual *= std::max(lobes.albedo(), least_survival);
    path.way.from_eye = false;
    path.bounces = 1;
    reflect(path, *start.point, lobes);
  }
}

void PathTracer::follow() {
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

// Follows the path through the surfaces found so far.
void PathTracer::advance(Path& path) {
  WayEvent event;
  while (ways_.next(path.way, event))
    if (!meet(path, event)) return;
  if (path.way.ahead.complete())
    end(path);
  else
    next_paths_.push_back(path);
}

// Handles a translucent surface on the path. Returns whether the path continues along the same ray; if it continues
// differently, it is added to the next paths.
bool PathTracer::meet(Path& path, WayEvent& event) {
  path.weight *= event.arriving;
  if (++path.events > most_events) return false;
  event.point.key = random_key({path.key, path.events});
  if (path.events > patient_events) {
    if (unit_float(random_key({event.point.key, for_roulette})) >= patience) return false;
    path.weight /= patience;
  }
  if (event.passage == Passage::mirrored) return pass(path, event);
  const shading::SrBlend& blend = event.point.blended;
  const glm::vec3 emitted = shading::sr_emitted(event.point.surface);
  if (emitted != glm::vec3(0.0f))
    sums_[path.sum].radiance += path.weight * blend.cover * emitted * counted(path, event.point.hit);
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
  if (!(largest(path.weight) > least_share * path.usual) || !is_finite(path.weight)) return false;
  return pass(path, event);
}

// Takes the path across a translucent surface, unless that reflects totally; returns the result of meet().
bool PathTracer::pass(Path& path, WayEvent& event) {
  if (event.passage == Passage::mirrored) {
    if (is_scattered(event.point)) turn_by_facet(path, event);
    bend(path, event, event.direction);
    return false;
  }
  if (event.passage == Passage::straight) {
    path.way.media = event.behind;
    return true;
  }
  if (event.passage == Passage::refracted && event.crossing.disperses) {
    // One random channel represents all three.
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

// Lets a facet of a rough surface decide whether the light leaves its solid.
void PathTracer::turn_by_facet(Path& path, WayEvent& event) {
  const RoughTurn turn = turned_by_facet(event.point, event.crossing, random_key({event.point.key, for_scattering}));
  event.direction = turn.direction;
  if (!turn.transmitted) return;
  event.passage = Passage::scattered;
  path.weight *= event.point.surface.tint;
}

// Continues the path in another direction. Light found along it is not sampled otherwise, so it has the full weight.
void PathTracer::bend(Path& path, const WayEvent& event, glm::vec3 direction) {
  ways_.redirect(path.way, event, direction);
  path.density = 0.0f;
  if (!path.way.from_eye) meet_lights_bent(path, event.point);  // the camera does not see lights
  next_paths_.push_back(path);
}

// Returns the weight of light from an emissive surface that the path hits, which is also sampled.
glm::vec3 PathTracer::counted(const Path& path, const Hit& hit) const {
  if (path.density > 0.0f)
    return glm::vec3(share_of_path(path.density, emitters_->density(path.from, hit, path.way.ray.direction)));
  return path.way.bent && emitters_->samples(hit) ? path.bent_share : glm::vec3(1.0f);
}

// Handles the opaque surface or the environment at the end of the path's ray.
void PathTracer::end(Path& path) {
  if (path.way.opaque.instance == no_instance) {
    path.weight *= ways_.arriving(path.way, farthest);
    if (path.way.from_eye) sums_[path.sum].sky += path.weight;
    if (scene_.environment->black()) return;
    const glm::vec3 direction = path.way.ray.direction;
    const float share = share_of_path(path.density, path.density > 0.0f ? scene_.environment->density(direction) : 0.0f);
    sums_[path.sum].radiance += path.weight * share * scene_.environment->radiance(direction);
    return;
  }
  path.weight *= ways_.arriving(path.way, static_cast<float>(path.way.opaque.distance));
  SurfacePoint point = ways_.end_point(path.way);
  if (++path.events > most_events) return;
  point.key = random_key({path.key, path.events});
  const glm::vec3 emitted = shading::sr_emitted(point.surface);
  if (emitted != glm::vec3(0.0f)) sums_[path.sum].radiance += path.weight * emitted * counted(path, path.way.opaque);
  if (!may_bounce(path)) return;
  const LobeSampler lobes(point);
  if (lobes.reflects()) bounce(path, point, lobes);
}

void PathTracer::bounce(Path& path, const SurfacePoint& point, const LobeSampler& lobes) {
  ++path.bounces;
  path.way.from_eye = false;
  find_lights(point, lobes, false);
  reflect(path, point, lobes);
}

// Adds direct light from lights and environment, and continues the path by reflection.
void PathTracer::reflect(Path& path, const SurfacePoint& point, const LobeSampler& lobes) {
  path.from = {point.position, point.surface.normal, point.surface.behind != glm::vec3(0.0f)};
  sample_lights(path, point, lobes);
  if (!scene_.environment->black()) sample_sky(path, point, lobes);
  if (!emitters_->empty()) sample_emitter(path, point, lobes);
  if (leave(path, point, lobes)) next_paths_.push_back(path);
}

// Continues the path by reflection. Returns false if it ends there.
bool PathTracer::leave(Path& path, const SurfacePoint& point, const LobeSampler& lobes) {
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
    const float survival = std::clamp(largest(path.weight) / path.usual, least_survival, most_survival);
    if (unit_float(random_key({path.key, path.events, for_roulette})) >= survival) return false;
    path.weight /= survival;
  }
  path.density = density;
  const Light light = path.way.light;
  const glm::vec3 away = leaving(point, direction);
  path.way = LightWay({start_of_ray(point, away), 0.0f, away, farthest}, point.cone, media_on(path.way, point, away));
  path.way.light = light;
  return true;
}

// Returns the density with which the current point continues paths in a direction.
float PathTracer::density(const LobeSampler& lobes, glm::vec3 direction) const {
  const float own = lobes.density(direction);
  return guided_ > 0.0f ? (1.0f - guided_) * own + guided_ * guide_.density(direction) : own;
}

// Finds the lights that may reach a point, without regard to occlusion, and the proportions in which they are sampled:
// by their reflected light. At the start of a path, lights without a size are added exactly instead.
void PathTracer::find_lights(const SurfacePoint& p, const LobeSampler& lobes, bool is_first) {
  lit_.clear();
  guide_.clear();
  draws_ = is_first ? first_draws : later_draws;
  float sum = 0.0f;
  for (const ReferenceLight& light : *scene_.lights) {
    LitBy lit{&light, {}, shading::sr_incidence(light.light, p.position), 0.0f};
    guide_.add(light, lit.incidence);
    const float irradiance = largest(lit.incidence.irradiance);
    if ((is_first && !light.sized()) || !(irradiance > 0.0f)) continue;
    const glm::vec3 reflected = shading::sr_reflect_light(p.surface, p.to_eye, lit.incidence.to_light);
    lit.chance = largest(reflected * lit.incidence.irradiance);
    if (light.sized()) {
      lit.cone = light_cone(light, p.position);
      lit.chance = std::max(lit.chance, least_lit * lobes.albedo() * irradiance);
    }
    if (!(lit.chance > 0.0f) || !std::isfinite(lit.chance)) continue;
    sum += lit.chance;
    lit_.push_back(lit);
  }
  for (LitBy& lit : lit_) lit.chance /= sum;
  guided_ = guide_.empty() ? 0.0f : most_guided * lobes.wide_share();
}

void PathTracer::sample_lights(const Path& path, const SurfacePoint& p, const LobeSampler& lobes) {
  if (lit_.empty()) return;
  const float u = random_point(path, for_choice).x;
  for (uint32_t draw = 0; draw < draws_; ++draw) {
    float left = (u + static_cast<float>(draw)) / static_cast<float>(draws_);
    size_t chosen = 0;
    while (chosen + 1 < lit_.size() && left >= lit_[chosen].chance) left -= lit_[chosen++].chance;
    sample_light(path, p, lobes, lit_[chosen], draw);
  }
}

void PathTracer::sample_light(const Path& path, const SurfacePoint& p, const LobeSampler& lobes, const LitBy& lit,
                              uint32_t draw) {
  const float draws = static_cast<float>(draws_);
  if (!lit.light->sized()) {
    const shading::SrIncidence& in = lit.incidence;
    const glm::vec3 gain = path.weight * shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance /
                           (draws * lit.chance);
    return send(beam_from(path, p, in.to_light, in.distance), gain, gain, BeamTarget::lamp);
  }
  const glm::vec2 u = random_point(path, for_lights + draw);
  const glm::vec3 direction = glm::normalize(model::Frame(lit.cone.axis).world(sample_cone(u, lit.cone.aperture)));
  const float weight =
      balance(draws, lit.chance / cone_solid_angle(lit.cone.aperture), 1.0f, density(lobes, direction));
  const glm::vec3 gain =
      path.weight * shading::sr_reflect_light(p.surface, p.to_eye, direction) * lit.cone.radiance * weight;
  send(beam_from(path, p, direction, distance_to_light(lit.cone, u.x * lit.cone.aperture)), gain,
       is_found(*lit.light) ? glm::vec3(0.0f) : gain, BeamTarget::lamp);
}

void PathTracer::sample_sky(const Path& path, const SurfacePoint& p, const LobeSampler& lobes) {
  const EnvironmentSampler::Sample s = scene_.environment->sample(random_point(path, for_sky));
  const glm::vec3 reflected = shading::sr_reflect_light(p.surface, p.to_eye, s.direction);
  if (!(largest(reflected) > 0.0f)) return;
  const float weight = balance(1.0f, density(lobes, s.direction), 1.0f, s.density);
  send(beam_from(path, p, leaving(p, s.direction), farthest),
       path.weight * reflected * scene_.environment->radiance(s.direction) * weight, glm::vec3(0.0f), BeamTarget::scene);
}

// Samples the light of an emissive surface.
void PathTracer::sample_emitter(const Path& path, const SurfacePoint& p, const LobeSampler& lobes) {
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
  const glm::vec3 gain = all * light * balance(1.0f, density(lobes, direction), 1.0f, s.density);
  const glm::vec3 bent_gain = settings_.caustics ? glm::vec3(0.0f) : reflected.wide * light / s.density;
  send(beam_from(path, p, direction, s.ray.t_far * (1.0f - short_of_emitter)), gain, bent_gain, BeamTarget::scene);
}

// Adds sized lights in the direction of a reflected path, which light samples find too. `density`: of the direction;
// the path's weight must include the reflection.
void PathTracer::meet_lights(const Path& path, const SurfacePoint& p, glm::vec3 direction, float density) {
  for (const LitBy& lit : lit_) {
    const LightCone& cone = lit.cone;
    const float below = cone.aperture > 0.0f ? below_axis(cone, direction) : 1.0f;
    if (below >= cone.aperture || !(largest(cone.radiance) > 0.0f)) continue;
    const float weight =
        density * balance(1.0f, density, static_cast<float>(draws_), lit.chance / cone_solid_angle(cone.aperture));
    const glm::vec3 gain = path.weight * cone.radiance * weight;
    send(beam_from(path, p, direction, distance_to_light(cone, below)), gain, is_found(*lit.light) ? glm::vec3(0.0f) : gain,
         BeamTarget::lamp);
  }
}

// Adds the lights in the direction of a refracted path.
void PathTracer::meet_lights_bent(const Path& path, const SurfacePoint& p) {
  const glm::vec3 direction = path.way.ray.direction;
  for (const ReferenceLight& light : *scene_.lights) {
    if (!is_found(light)) continue;
    const LightCone cone = light_cone(light, p.position);
    const float below = below_axis(cone, direction);
    if (below >= cone.aperture || !(largest(cone.radiance) > 0.0f)) continue;
    Ray ray = path.way.ray;
    ray.t_far = distance_to_light(cone, below);
    send({ray, path.way.media, path.sum, {}, {}}, path.weight * cone.radiance, glm::vec3(0.0f), BeamTarget::lamp);
  }
}

// Returns the media on the side of point p into which this direction leads.
MediumStack PathTracer::media_on(const LightWay& way, const SurfacePoint& p, glm::vec3 direction) const {
  return glm::dot(p.geometric_normal, direction) >= 0.0f ? way.media : ways_.behind(p, way.media);
}

Beam PathTracer::beam_from(const Path& path, const SurfacePoint& p, glm::vec3 direction, float length) const {
  return {{start_of_ray(p, direction), 0.0f, direction, length}, media_on(path.way, p, direction), path.sum, {}, {}};
}

void PathTracer::send(Beam beam, glm::vec3 gain, glm::vec3 bent_gain, BeamTarget target) {
  if (!(largest(gain) > 0.0f || largest(bent_gain) > 0.0f) || !is_finite(gain) || !is_finite(bent_gain)) return;
  if (!settings_.shadows && target == BeamTarget::lamp) {
    sums_[beam.sum].radiance += gain;
    return;
  }
  beam.ray.t_far *= 1.0f - short_of_light;
  beam.gain = gain, beam.bent_gain = bent_gain;
  beams_.add(target, beam);
}

void PathTracer::end_beams() {
  beams_.end([this](uint32_t sum, glm::vec3 light) { sums_[sum].radiance += light; });
}

glm::vec2 PathTracer::random_point(const Path& path, uint32_t purpose) const {
  return PointSet(random_key({path.set, purpose, path.bounces}))[path.number];
}

}  // namespace sideray::rt
