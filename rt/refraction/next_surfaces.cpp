#include "rt/refraction/next_surfaces.h"

#include <algorithm>
#include <limits>

namespace sideray::rt {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr uint32_t not_made = RefractedPath::not_made;

}  // namespace

void NextSurfaces::begin(const RefractionContext& context, Purpose purpose, Counters& counters) {
  context_ = &context, purpose_ = purpose, counters_ = &counters;
  kernels_ = &shade_kernels(context.frame->intersector->isa().c_str());
}

SurfacePoint* NextSurfaces::make(std::span<const HitPlace> places) {
  make_from(0, places);
  return made_.data();
}

void NextSurfaces::find(std::span<RefractedPath> paths, std::span<const uint32_t> active) {
  paths_ = paths;
  made_count_ = 0;
  pending_.assign(active.begin(), active.end());
  for (const uint32_t i : pending_) {
    RefractedPath& path = paths_[i];
    path.next.instance = no_instance;
    path.surface = not_made;
    path.way_out = infinity;
    path.search = next_search(path);
  }
  while (!pending_.empty()) {
    find_places();
    find_opaque();
    find_layers();
    make_next();
    std::erase_if(pending_, [&](uint32_t i) { return settle(paths_[i]); });
  }
}

NextSurfaces::Search NextSurfaces::next_search(const RefractedPath& path) const {
  if (path.met >= path.wanted) return absorbs(path) && !path.ahead.complete() ? Search::rest : Search::opaque;
  if (path.ahead.count > 0 || path.ahead.complete()) return Search::nothing;
  return path.refracted && path.ahead.last.instance == no_instance && !path.ahead.deep ? Search::place : Search::rest;
}

// Returns whether the ray's end is needed before its next surface is made, because sprites fade in front of opaque
// surfaces.
bool NextSurfaces::wants_end(const RefractedPath& path) const {
  const std::vector<model::Instance>& instances = context_->scene->surfaces.snapshot->instances;
  const Hit* hits = path.ahead.hits;
  return path.clear != farthest &&
         std::any_of(hits, hits + path.ahead.count, [&](const Hit& h) { return instances[h.instance].sprites != 0; });
}

// Returns whether the end of the path's medium is needed.
bool NextSurfaces::absorbs(const RefractedPath& path) const {
  return purpose_ == Purpose::light && !path.media.empty() &&
         context_->scene->medium(path.media.top()).absorption != glm::vec3(0.0f);
}

// Returns whether the hit is where a ray leaves an instance.
bool NextSurfaces::leaves(const Hit& hit) const {
  return !context_->scene->surfaces.snapshot->instances[hit.instance].solid || !hit.front;
}

// Returns the cone for the alpha of all paths.
Cone NextSurfaces::common_cone() const {
  const FrameContext& frame = *context_->frame;
  return frame.view->cone(frame.request->width / 2, frame.request->height / 2);
}

void NextSurfaces::find_places() {
  constexpr uint32_t most = Intersector::most_at_place;
  static_assert(most <= SurfacesAhead::most);
  group_.clear();
  rays_.clear();
  for (const uint32_t i : pending_) {
    if (paths_[i].search != Search::place) continue;
    group_.push_back(i);
    rays_.push_back(paths_[i].ray);
  }
  if (rays_.empty()) return;
  hits_.resize(rays_.size() * most);
  hit_counts_.resize(rays_.size());
  known_.resize(rays_.size());
  const FrameContext& frame = *context_->frame;
  frame.intersector->nearest_places(frame.set, rays_,
                                    {.coherent = directions_agree(rays_), .cone = common_cone(), .cull = false},
                                    hits_.data(), hit_counts_.data(), known_.data());
  counters_->rays_primary += rays_.size();
  for (size_t k = 0; k < group_.size(); ++k) {
    RefractedPath& path = paths_[group_[k]];
    path.ahead.take_place({&hits_[k * most], hit_counts_[k]}, known_[k], path.ray);
  }
}

// Finds the opaque ends of refracted rays, up to the translucent surfaces found before. Refracted or not, they are
// primary rays and pass backs of materials that are not double sided.
void NextSurfaces::find_opaque() {
  rays_.clear();
  group_.clear();
  for (const uint32_t i : pending_) {
    RefractedPath& path = paths_[i];
    if (path.search == Search::nothing || path.clear == farthest) continue;
    Ray ray = path.ray;
    ray.t_near = path.clear;  // initially 0, in front of the surface, because another may lie on it
    if (path.search == Search::place && !path.ahead.complete())
      ray.t_far = static_cast<float>(path.ahead.known) * (1.0f + 2.0f * on_opaque_surface);
    path.clear = ray.t_far;
    rays_.push_back(ray);
    group_.push_back(i);
  }
  if (rays_.empty()) return;
  hits_.resize(rays_.size());
  const OpaqueSearch search{
      .set = OpaqueSet::all, .coherent = directions_agree(rays_), .cone = common_cone(), .cull = true};
  context_->frame->intersector->nearest_opaque(rays_, search, hits_.data());
  counters_->rays_primary += rays_.size();
  for (size_t k = 0; k < group_.size(); ++k) {
    if (hits_[k].instance == no_instance) continue;
    RefractedPath& path = paths_[group_[k]];
    path.opaque = hits_[k];
    path.clear = farthest;
    path.ray.t_far = static_cast<float>(path.opaque.distance) * (1.0f - on_opaque_surface);
    path.ahead.end_at(path.ray.t_far);
  }
}

void NextSurfaces::find_layers() {
  for (const uint32_t layers : {SurfacesAhead::most, most_layers_in_round})
    for (const bool cull : {true, false}) {
      group_.clear();
      for (const uint32_t i : pending_) {
        const RefractedPath& path = paths_[i];
        if (path.search == Search::rest && path.ahead.deep == (layers != SurfacesAhead::most) &&
            path.hits_culled() != cull)
          group_.push_back(i);
      }
      if (!group_.empty()) traverse_group(layers, cull);
    }
}

void NextSurfaces::traverse_group(uint32_t layers, bool cull) {
  rays_.clear();
  for (const uint32_t i : group_) {
    rays_.push_back(paths_[i].ray);
    paths_[i].search = Search::nothing;
  }
  hits_.resize(rays_.size() * layers);
  hit_counts_.resize(rays_.size());
  const FrameContext& frame = *context_->frame;
  frame.intersector->nearest_layers(
      frame.set, rays_, {.layers = layers, .coherent = directions_agree(rays_), .cone = common_cone(), .cull = cull},
      hits_.data(), hit_counts_.data());
  counters_->rays_primary += rays_.size();
  const std::vector<model::Instance>& instances = context_->scene->surfaces.snapshot->instances;
  for (size_t i = 0; i < group_.size(); ++i) {
    RefractedPath& path = paths_[group_[i]];
    path.ahead.take(instances, {&hits_[i * layers], hit_counts_[i]}, layers, path.ray);
  }
}

// Makes surfaces in made_, from index `first` on.
void NextSurfaces::make_from(size_t first, std::span<const HitPlace> places) {
  if (made_.size() < first + places.size()) made_.resize(first + places.size());
  make_surfaces(context_->scene->surfaces, *kernels_, places, made_.data() + first);
}

// Makes all surfaces that paths hit next at once, because most of them are crossed.
void NextSurfaces::make_next() {
  places_.clear();
  const size_t first = made_count_;
  for (const uint32_t i : pending_) {
    RefractedPath& path = paths_[i];
    if (path.ahead.count == 0 || path.met >= path.wanted || path.surface != not_made || wants_end(path)) continue;
    path.surface = static_cast<uint32_t>(made_count_++);
    places_.push_back({&path.ahead.hits[0], &path.ray, path.cone});
  }
  make_from(first, places_);
}

// Sets the next surface ahead that counts. Returns false if it is not known yet, and sets what must be searched.
bool NextSurfaces::settle(RefractedPath& path) const {
  if (path.met >= path.wanted) return find_way_out(path);
  path.search = Search::nothing;
  while (path.ahead.count > 0) {
    if (path.surface == not_made) {  // it must be made
      if (wants_end(path)) path.search = Search::opaque;
      return false;
    }
    if (!path.ahead.knows_place(made_[path.surface])) {
      path.search = Search::rest;
      return false;
    }
    take_next(path);
    if (counts(path)) return true;
    path.next.instance = no_instance;
    path.surface = not_made;
  }
  path.search = next_search(path);
  return path.search == Search::nothing;
}

// Finds the end of the path's medium behind the last surface that counts.
bool NextSurfaces::find_way_out(RefractedPath& path) const {
  if (!absorbs(path)) return true;
  while (path.ahead.count > 0) {
    const Hit hit = path.ahead.remove(0);
    if (hit.instance != path.media.top() || !leaves(hit)) continue;
    path.way_out = static_cast<float>(hit.distance);
    return true;
  }
  path.search = Search::rest;
  return path.ahead.complete();
}

// Removes the next hit from those ahead.
void NextSurfaces::take_next(RefractedPath& path) const {
  const auto exits = [&](const Hit& h) { return context_->scene->medium(h.instance).volume && leaves(h); };
  uint32_t chosen = 0;
  if (path.ahead.count > 1 && exits(path.ahead.hits[0]))
    chosen = first_entered(path.ahead, made_[path.surface], exits);
  path.next = path.ahead.remove(chosen);
  if (chosen != 0) path.surface = not_made;
}

// Returns whether the path's next hit counts; if it does not, updates the path's media.
bool NextSurfaces::counts(RefractedPath& path) const {
  const Hit& hit = path.next;
  const RefractionScene& scene = *context_->scene;
  const model::Snapshot& snapshot = *scene.surfaces.snapshot;
  const bool volume = scene.medium(hit.instance).volume;
  const bool culled = snapshot.materials[snapshot.instances[hit.instance].material].cull_back && !hit.front;
  if (culled && !(path.hits_culled() && volume)) return false;
  if (!volume) return true;
  MediumStack behind = path.media;
  if (cross(scene, hit, path.met == 0 && !path.refracted, behind, path.light).interface) return true;
  path.media = behind;
  return false;
}

}  // namespace sideray::rt
