#include "rt/refraction/refraction_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"
#include "rt/embree/recompute.h"

namespace sideray::rt {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
// Paths end below these transmittances, in composites and in references.
constexpr float least_transmittance = 1e-4f, least_exact_transmittance = 1e-6f;
// Separates the random numbers of scattering from others of the same key.
constexpr uint32_t scatter_purpose = 0x5ca77e2u, dispersion_purpose = 0xd15be25eu;

}  // namespace

TraceEnd RefractionTracer::trace(const RefractionContext& context, std::span<const PixelRequest> pixels,
                                 PointShader& shader, std::vector<RefractedPixel>& result, Counters& counters) {
  const ShaderWork before = shader;
  begin(context, shader, result, counters);
  result.assign(pixels.size(), RefractedPixel{});
  start(pixels);
  if (run() != TraceEnd::complete) return shader.end;
  for (size_t i = 0; i < pixels.size(); ++i) {  // the first paths are those of the pixels
    counters.traversals_wasted += paths_[i].met == 0;
    counters.layers_requested += pixels[i].layers == unlimited_layers ? paths_[i].met : pixels[i].layers;
  }
  for (const RefractedPath& path : paths_) counters.layers_found += path.met;
  counters.pixels_masked += pixels.size();
  add_work(shader, before, counters);
  return TraceEnd::complete;
}

TraceEnd RefractionTracer::follow(const RefractionContext& context, std::span<const FirstBend> bends,
                                  PointShader& shader, std::vector<RefractedPixel>& result, Counters& counters) {
  const ShaderWork before = shader;
  begin(context, shader, result, counters);
  result.assign(bends.size(), RefractedPixel{});
  start(bends);
  run();
  add_work(shader, before, counters);
  return shader.end;
}

void RefractionTracer::find_ends(const RefractionContext& context, std::span<const PixelRequest> pixels,
                                 std::vector<PathEnd>& ends, Counters& counters, std::vector<PathSurface>* surfaces) {
  context_ = &context, shader_ = nullptr, counters_ = &counters, result_ = nullptr, path_ends_ = &ends;
  path_surfaces_ = surfaces;
  if (surfaces) surfaces->clear();
  next_surfaces_.begin(context, NextSurfaces::Purpose::ends, counters);
  ends.assign(pixels.size(), PathEnd{});
  start(pixels);
  while (!active_.empty()) advance_all();
}

void RefractionTracer::begin(const RefractionContext& context, PointShader& shader,
                             std::vector<RefractedPixel>& result, Counters& counters) {
  context_ = &context, shader_ = &shader, counters_ = &counters, result_ = &result, path_ends_ = nullptr;
  path_surfaces_ = nullptr;
  next_surfaces_.begin(context, NextSurfaces::Purpose::light, counters);
  kernels_ = &shade_kernels(context.frame->intersector->isa().c_str());
  reuse_.begin(0.0f);
  // A cancelled trace may have left entries.
  points_.clear();
  media_.clear();
  shares_.clear();
  ends_.clear();
}

TraceEnd RefractionTracer::run() {
  while (!active_.empty()) {
    advance_all();
    shade_events();
    if (shader_->end != TraceEnd::complete) return shader_->end;
  }
  shade_ends();
  return shader_->end;
}

// Advances every active path by one surface.
void RefractionTracer::advance_all() {
  next_surfaces_.find(paths_, active_);
  next_active_.clear();
  for (const uint32_t path : active_) advance(path);
  std::swap(active_, next_active_);
}

// Resets a path to its primary ray.
RefractedPath& RefractionTracer::path_from_eye(uint32_t i, uint32_t key, const Ray& ray, Cone cone) {
  RefractedPath& path = paths_[i];
  path = {};
  path.pixel = i;
  path.key = key;
  path.estimate = both_estimates;
  path.ray = ray;
  path.cone = cone;
  path.through = glm::vec3(1.0f);
  path.media = context_->at_eye;
  path.opaque.instance = no_instance;
  path.clear = farthest;
  return path;
}

void RefractionTracer::start(std::span<const FirstBend> bends) {
  const LayerRequest& request = *context_->frame->request;
  reuse_.begin(shader_->sharing() && shader_->estimates() == 1 ? request.ray_reuse : 0.0f);
  bends_ = bends;
  paths_.resize(bends.size());
  places_.clear();
  for (uint32_t i = 0; i < bends.size(); ++i) {
    const FirstBend& bend = bends[i];
    RefractedPath& path = path_from_eye(i, bend.key, bend.ray, bend.cone);
    path.met = bend.before;
    path.wanted = bend.before + most_events_behind;
    places_.push_back({&bend.hit, &bend.ray, bend.cone});
  }
  SurfacePoint* surfaces = next_surfaces_.make(places_);
  active_.clear();
  next_active_.clear();
  const auto is_donor = [&](uint32_t path) { return bends[paths_[path].pixel].pixel.is_donor(); };
  order_.resize(bends.size());  // donors come first, and so do their points
  std::iota(order_.begin(), order_.end(), 0u);
  std::stable_partition(order_.begin(), order_.end(), is_donor);
  for (const uint32_t i : order_)
    if (meets(i, bends[i].hit, &surfaces[i], bends[i].is_lit) && !finished(paths_[i])) active_.push_back(i);
  active_.insert(active_.end(), next_active_.begin(), next_active_.end());
  std::stable_partition(active_.begin(), active_.end(), is_donor);
}

void RefractionTracer::start(std::span<const PixelRequest> pixels) {
  const FrameContext& frame = *context_->frame;
  const LayerRequest& request = *frame.request;
  paths_.resize(pixels.size());
  active_.resize(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const PixelRequest& p = pixels[i];
    const auto index = active_[i] = static_cast<uint32_t>(i);
    RefractedPath& path = path_from_eye(index, pixel_key(request.seed, frame.position, p.x, p.y), frame.view->ray(p.x, p.y),
                               frame.view->cone(p.x, p.y));
    path.wanted = std::min(p.layers, most_events);
    if (frame.ends)
      path.ray.t_far = frame.ends[size_t{p.y} * request.width + p.x];
    else if (request.depth.texels)
      path.ray.t_far =
          frame.view->end_of_ray(p.x, p.y, read_depth(request.depth, p.x, p.y).depth, request.depth.format);
  }
}

// Takes the path across its next surface, or ends it.
void RefractionTracer::advance(uint32_t i) {
  const Hit hit = paths_[i].next;
  if (hit.instance == no_instance) return end(i);
  const bool hit_culled = paths_[i].hits_culled();
  meets(i, hit, next_surfaces_.surface_of(paths_[i]));
  RefractedPath& path = paths_[i];
  // From here on back faces count too.
  if (!path.refracted && !hit_culled && path.hits_culled()) path.ahead.forget_behind(hit, path.ray);
  if (!finished(path))
    next_active_.push_back(i);
  else if (!path.refracted)
    (*result_)[path.pixel].transmittance = path.through;
}

// Handles a surface that the path hit; returns false if the medium is the same on both sides. `is_lit`: the light of
// the surface itself has already been added.
bool RefractionTracer::meets(uint32_t i, const Hit& hit, SurfacePoint* surface, bool is_lit) {
  const RefractionScene& scene = *context_->scene;
  const bool volume = scene.medium(hit.instance).volume;
  RefractedPath& path = paths_[i];
  MediumStack before = path.media, behind = path.media;
  Crossing crossing{true, 1.0f, 1.0f, no_instance, false};
  if (volume) crossing = cross(scene, hit, path.met == 0 && !path.refracted, behind, path.light);
  if (!crossing.interface) {
    path.media = behind;
    return false;
  }
  if (crossing.absorber != no_instance) before.push(crossing.absorber);
  const auto distance = static_cast<float>(hit.distance);
  path.through *= scene.transmittance(before, distance - path.start);
  path.start = distance;
  SurfacePoint made;
  if (!surface) made = surface_point(scene.surfaces, hit, path.ray, path.cone);
  SurfacePoint& point = surface ? *surface : made;
  point.key = random_key({path.key, path.met++});
  if (path_surfaces_)
    path_surfaces_->push_back({path.pixel, hit, path.ray, path.length, point.surface.normal, point.geometric_normal});
  if (volume)
    pass(i, hit, point, crossing, behind, is_lit);
  else if (is_scattered(point) && !path_ends_)
    blend(path, point, is_lit), scatter(i, point, crossing);
  else
    blend(path, point, is_lit);
  return true;
}

// Takes the path into a volume or out of it, unless the surface reflects totally.
void RefractionTracer::pass(uint32_t i, const Hit& hit, SurfacePoint& point, const Crossing& crossing,
                            const MediumStack& behind, bool is_lit) {
  RefractedPath& path = paths_[i];
  const Bend b = bend(point.to_eye, facing_normal(point), crossing.ior_from, crossing.ior_to);
  if (b.total && !crossing.disperses) return reflect_totally(path, point, crossing, behind, b.direction);
  set_reflectance(crossing, b.cosine, point.surface);
  point.blended = shading::sr_blend(point.surface, point.to_eye, point.blend);
  blend(path, point, is_lit);
  const MediumStack before = path.media;
  path.media = behind;
  if (crossing.ior_from == crossing.ior_to && !crossing.disperses) return;
  if (is_scattered(point) && !path_ends_)
    scatter(i, point, crossing);
  else if (crossing.disperses && !path_ends_)
    disperse(i, point, hit, before);
  else
    redirect(path, point, b.direction, true);
}

// Continues the path in the mirror direction, or, on a rough surface, as one of its facets decides.
void RefractionTracer::reflect_totally(RefractedPath& path, const SurfacePoint& point, const Crossing& crossing,
                                       const MediumStack& behind, glm::vec3 mirrored) const {
  if (!is_scattered(point) || path_ends_) return redirect(path, point, mirrored, false);
  const RoughTurn turn = turned_by_facet(point, crossing, random_key({point.key, scatter_purpose}));
  if (turn.transmitted) {
    path.through *= point.surface.tint;
    path.media = behind;
  }
  redirect(path, point, turn.direction, turn.transmitted);
}

// Splits the path into three, one a channel. KHR_materials_dispersion gives the indices of these three, so wavelengths
// need not be sampled, and a frame has no noise from them. From here on each path is followed separately.
void RefractionTracer::disperse(uint32_t i, const SurfacePoint& point, const Hit& hit, const MediumStack& before) {
  const RefractedPath whole = paths_[i];
  for (const Light light : {Light::red, Light::green, Light::blue}) {
    if (light != Light::red) {
      paths_.push_back(whole);
      paths_.back().met = 0;  // the new path counts its own hits
      paths_.back().wanted = whole.wanted - whole.met;
      next_active_.push_back(static_cast<uint32_t>(paths_.size() - 1));
    }
    RefractedPath& path = light == Light::red ? paths_[i] : paths_.back();
    path.light = light;
    path.through *= channels_of(light);
    path.key = random_key({whole.key, dispersion_purpose, static_cast<uint32_t>(light)});
    MediumStack behind = before;
    const Crossing crossing = cross(*context_->scene, hit, whole.met == 1 && !whole.refracted, behind, light);
    const Bend b = bend(point.to_eye, facing_normal(point), crossing.ior_from, crossing.ior_to);
    path.media = b.total ? before : behind;
    redirect(path, point, b.direction, !b.total);
  }
}

// Stores how widely the first rough surface on a path scatters. A facet tilted by an angle turns a mirrored ray by
// twice that angle; a ray refracted into a body and out of it turns by n - 1 times the angle at each of the two
// surfaces.
void RefractionTracer::widen(const RefractedPath& path, const SurfacePoint& point, const Crossing& crossing) {
  RefractedPixel& pixel = (*result_)[path.pixel];
  if (pixel.roughness > 0.0f) return;
  const float ratio = crossing.ior_to / crossing.ior_from;
  pixel.roughness = point.surface.roughness;
  pixel.spread = ratio == 1.0f ? 1.0f : std::min(0.7f * std::abs(ratio - 1.0f), 1.0f);
}

// Continues the path in a random direction of microfacet refraction. A path of a reference that has not been split yet
// is split into several.
void RefractionTracer::scatter(uint32_t i, const SurfacePoint& point, const Crossing& crossing) {
  const bool splits = context_->exact && paths_[i].estimate == both_estimates;
  const RefractedPath whole = paths_[i];
  widen(whole, point, crossing);
  for (uint32_t copy = 0; copy < (splits ? scattered_paths : 1); ++copy) {
    const glm::vec3 direction = scattered_direction(point, crossing, random_key({point.key, scatter_purpose, copy}));
    if (copy > 0) {
      paths_.push_back(whole);
      paths_.back().met = 0;  // the new path counts its own hits
      next_active_.push_back(static_cast<uint32_t>(paths_.size() - 1));
    }
    RefractedPath& path = copy == 0 ? paths_[i] : paths_.back();
    if (splits) {
      path.estimate = static_cast<int>(copy % 2);
      path.through *= 2.0f / static_cast<float>(scattered_paths);
      path.key = random_key({whole.key, scatter_purpose, copy});
      path.wanted = whole.wanted - (whole.met - path.met);
    }
    redirect(path, point, direction, true);
  }
}

void RefractionTracer::redirect(RefractedPath& path, const SurfacePoint& point, glm::vec3 direction, bool transmitted) const {
  const OnwardRay onward = onward_ray(point, path.start, direction, transmitted);
  if (path.refracted) path.way += path.start;
  path.length += static_cast<double>(path.start);
  ++path.turns;
  path.ray = onward.ray;
  path.cone = point.cone;
  path.refracted = true;
  path.clear = 0.0f;
  path.opaque.instance = no_instance;
  if (!transmitted) path.ahead.count = 0;
  path.ahead.start_anew(onward.limit);
  path.start = 0.0f;
}

void RefractionTracer::blend(RefractedPath& path, const SurfacePoint& point, bool is_lit) {
  if (path_ends_) return;
  const shading::SrBlend b = blend_of(point);
  if (b.cover > 0.0f && !is_lit) {
    points_.push_back(point);
    const bool is_sprite = context_->scene->surfaces.snapshot->instances[point.hit.instance].sprites != 0;
    points_.back().weight = largest(path.through) * (is_sprite ? 1.0f : b.cover);  // as in LayerTracer
    media_.push_back(path.media);
    shares_.push_back({path.pixel, path.estimate, path.through * b.cover});
  }
  path.through *= b.through;
}

bool RefractionTracer::finished(const RefractedPath& path) const {
  if (path_ends_) return false;
  const float most = std::max({path.through.x, path.through.y, path.through.z});
  return most < (context_->exact ? least_exact_transmittance : least_transmittance);
}

void RefractionTracer::end(uint32_t i) {
  RefractedPath& path = paths_[i];
  if (path_ends_) {
    (*path_ends_)[i] = {path.ray, path.opaque, path.length, path.turns,
                         path.met < path.wanted};
    return;
  }
  const bool opaque = path.refracted ? path.opaque.instance != no_instance : path.ray.t_far < farthest;
  const float length = path.refracted ? static_cast<float>(path.opaque.distance) : path.ray.t_far;
  const float end = std::min(opaque ? length : infinity, path.way_out);
  path.through *= context_->scene->transmittance(path.media, end - path.start);
  RefractedPixel& pixel = (*result_)[path.pixel];
  if (path.refracted && opaque) pixel.nearness = 1.0f / (path.way + length);
  if (!path.refracted) {
    pixel.transmittance = path.through;
  } else if (opaque) {
    ends_.push_back(i);
  } else {
    const glm::vec3 radiance = shader_->surroundings(path.ray.direction, 0.0f);
    const glm::vec3 estimates[2] = {radiance, radiance};
    add({path.pixel, path.estimate, path.through}, estimates);
    pixel.sky += path.through * (path.estimate == both_estimates ? 1.0f : 0.5f);
  }
}

void RefractionTracer::add(const Share& share, const glm::vec3* radiance) {
  RefractedPixel& pixel = (*result_)[share.pixel];
  for (int e = 0; e < static_cast<int>(shader_->estimates()); ++e)
    if (share.estimate == both_estimates || share.estimate == e) pixel.radiance[e] += radiance[e] * share.weight;
}

void RefractionTracer::shade_events() {
  radiance_.resize(points_.size() * shader_->estimates());
  if (reuse_.active()) {
    point_pixels_.clear();
    for (const Share& share : shares_) point_pixels_.push_back(bends_[share.pixel].pixel);
    reuse_.shade(*shader_, points_, point_pixels_, radiance_.data());
  } else {
    shader_->within(media_.data());
    shader_->shade(points_, radiance_.data());
  }
  add_points();
}

// Shades the opaque ends of refracted rays.
void RefractionTracer::shade_ends() {
  places_.clear();
  for (const uint32_t i : ends_) {
    const RefractedPath& path = paths_[i];
    places_.push_back({&path.opaque, &path.ray, path.cone});
    media_.push_back(path.media);
    shares_.push_back({path.pixel, path.estimate, path.through});
  }
  append_surfaces(context_->scene->surfaces, *kernels_, places_, points_);
  for (size_t k = 0; k < ends_.size(); ++k) {
    const RefractedPath& path = paths_[ends_[k]];
    points_[k].key = random_key({path.key, path.met});
    points_[k].weight = largest(path.through);
  }
  radiance_.resize(points_.size() * shader_->estimates());
  shader_->within(media_.data());
  shader_->shade_opaque(points_, radiance_.data());
  add_points();
}

// Adds the radiance of points_ to their pixels, and clears them.
void RefractionTracer::add_points() {
  const size_t estimates = shader_->estimates();
  for (size_t i = 0; i < points_.size(); ++i) add(shares_[i], &radiance_[i * estimates]);
  points_.clear();
  media_.clear();
  shares_.clear();
}

}  // namespace sideray::rt
