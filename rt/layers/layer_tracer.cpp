#include "rt/layers/layer_tracer.h"

#include <sideray/diagnostics.h>

#include <algorithm>
#include <array>

#include "rt/base/sampling.h"
#include "rt/embree/recompute.h"
#include "rt/layers/sprite_lights.h"

namespace sideray::rt {
namespace {

constexpr size_t events_in_batch = 512;
// Rays are reused within a batch: a larger one has more donors, until it no longer fits the processor's cache.
constexpr size_t events_that_reuse = 2048;

}  // namespace

void add_work(const ShaderWork& after, const ShaderWork& before, Counters& counters) {
  counters.rays_reflection += after.rays_reflection - before.rays_reflection;
  counters.rays_shadow += after.rays_shadow - before.rays_shadow;
  counters.rays_bounce += after.rays_bounce - before.rays_bounce;
  counters.points_shaded += after.points_asked - before.points_asked;
  counters.points_not_finite += after.points_not_finite - before.points_not_finite;
}

TraceEnd LayerTracer::trace(const FrameContext& frame, std::span<const PixelRequest> pixels, PointShader& shader,
                            LayerSink& sink, Counters& counters) {
  frame_ = &frame, shader_ = &shader, sink_ = &sink, counters_ = &counters;
  const ShaderWork before = shader;
  start(pixels);
  sink.begin(pixels);
  while (!active_.empty()) {
    traverse_active();
    shade_events();
    if (is_given_up()) return shader.end;
    active_.clear();
    for (const uint32_t pixel : next_active_)
      if (!sink.finished(pixel)) active_.push_back(pixel);
  }
  sink.end(pixels);
  for (size_t i = 0; i < pixels.size(); ++i) {
    counters.layers_found += states_[i].found;
    counters.traversals_wasted += states_[i].found == 0;
    counters.layers_requested += pixels[i].layers == unlimited_layers ? states_[i].found : pixels[i].layers;
  }
  counters.pixels_masked += pixels.size();
  add_work(shader, before, counters);
  return shader.end;
}

void LayerTracer::start(std::span<const PixelRequest> pixels) {
  const LayerRequest& request = *frame_->request;
  requests_ = pixels;
  kernels_ = &shade_kernels(frame_->intersector->isa().c_str());
  events_.clear();  // left over from a trace that was skipped
  reuse_.begin(shader_->sharing() ? request.ray_reuse : 0.0f);
  states_.resize(pixels.size());
  active_.resize(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const PixelRequest& p = pixels[i];
    PixelState& s = states_[i];
    s.step = {};
    s.step.last.instance = no_instance;
    s.key = pixel_key(request.seed, frame_->position, p.x, p.y);
    s.wanted = p.layers;
    s.found = 0;
    active_[i] = static_cast<uint32_t>(i);
  }
  for (size_t first = 0; first < pixels.size(); first += ViewRays::Block::size)
    aim(pixels.subspan(first, std::min<size_t>(ViewRays::Block::size, pixels.size() - first)), &states_[first]);
}

// Sets rays and cones of up to a block of pixels; the last pixel fills unused lanes.
void LayerTracer::aim(std::span<const PixelRequest> pixels, PixelState* states) {
  const LayerRequest& request = *frame_->request;
  const bool has_depth = !frame_->ends && request.depth.texels;
  ViewRays::Block block;
  for (size_t i = 0; i < ViewRays::Block::size; ++i) {
    const PixelRequest& p = pixels[std::min(i, pixels.size() - 1)];
    block.x[i] = p.x;
    block.y[i] = p.y;
    block.depth[i] = has_depth ? read_depth(request.depth, p.end_x, p.end_y).depth : frame_->view->far_depth();
  }
  std::array<Ray, ViewRays::Block::size> rays;
  std::array<Cone, ViewRays::Block::size> cones;
  frame_->view->fill(block, request.depth.format, rays.data(), cones.data());
  for (size_t i = 0; i < pixels.size(); ++i) {
    states[i].ray = rays[i];
    states[i].cone = cones[i];
    if (frame_->ends) states[i].ray.t_far = frame_->ends[size_t{pixels[i].y} * request.width + pixels[i].x];
  }
}

// Runs one round of traversals; fills events_ and next_active_.
void LayerTracer::traverse_active() {
  next_active_.clear();
  std::array<bool, most_layers_in_round + 1> wanted{};
  layers_.clear();
  for (const uint32_t pixel : active_) {
    const PixelState& s = states_[pixel];
    layers_.push_back(layers_in_traversal(frame_->request->step, s.step, s.wanted - s.found));
    wanted[layers_.back()] = true;
  }
  for (uint32_t layers = 1; layers < wanted.size(); ++layers) {
    if (!wanted[layers] || is_given_up()) continue;
    group_.clear();
    for (size_t i = 0; i < active_.size(); ++i)
      if (layers_[i] == layers) group_.push_back(active_[i]);
    traverse_group(layers);
  }
}

void LayerTracer::traverse_group(uint32_t layers) {
  rays_.clear();
  for (const uint32_t pixel : group_) rays_.push_back(states_[pixel].ray);
  hits_.resize(group_.size() * layers);
  hit_counts_.resize(group_.size());
  frame_->intersector->nearest_layers(frame_->set, rays_, {.layers = layers, .coherent = true, .cone = frame_->view->alpha_cone()},
                                      hits_.data(), hit_counts_.data());
  counters_->rays_primary += group_.size();
  for (size_t i = 0; i < group_.size(); ++i) take_hits(group_[i], &hits_[i * layers], hit_counts_[i], layers);
}

void LayerTracer::take_hits(uint32_t pixel, const Hit* hits, uint32_t count, uint32_t layers) {
  PixelState& s = states_[pixel];
  const sideray_step policy = frame_->request->step;
  const uint32_t most = new_layers_in_traversal(policy);
  uint32_t met = 0, taken = 0;
  for (; met < count && taken < most && s.found < s.wanted; ++met) {
    const Hit& hit = hits[met];
    if (policy != SIDERAY_STEP_LISTING && !is_next(s.step.last, hit)) continue;
    ++taken;
    s.step.last = hit;
    if (!accepted(hit)) continue;
    events_.push_back({pixel, s.found++, hit});
    if (bends(hit)) s.wanted = s.found;
  }
  const bool exhausted = met == count && count < layers;
  // A full traversal without a new surface ends the ray: more surfaces than it can hold are within rounding of each
  // other.
  if (!exhausted && taken > 0 && s.found < s.wanted) {
    step_on(policy, {hits, met}, s.step, s.ray);
    next_active_.push_back(pixel);
  }
  if (events_.size() >= (reuse_.active() ? events_that_reuse : events_in_batch)) shade_events();
}

// Returns whether a hit lies behind the last one in the total order of a ray's surfaces.
bool LayerTracer::is_next(const Hit& last, const Hit& hit) const {
  if (last.instance == no_instance) return true;
  const std::vector<model::Instance>& instances = frame_->scene->snapshot->instances;
  return nearer(last, instances[last.instance].surface_id, hit, instances[hit.instance].surface_id);
}

bool LayerTracer::accepted(const Hit& hit) const {
  if (!frame_->cache) return true;
  const model::Snapshot& snapshot = *frame_->scene->snapshot;
  const model::Instance& instance = snapshot.instances[hit.instance];
  return instance.surface_id != 0 && snapshot.materials[instance.material].traceable;
}

// Returns whether straight rays end at the hit, because its surface bends light.
bool LayerTracer::bends(const Hit& hit) const {
  if (frame_->bends.empty()) return false;
  return frame_->bends[frame_->scene->snapshot->instances[hit.instance].material] != 0;
}

void LayerTracer::shade_events() {
  if (is_given_up()) return events_.clear();
  if (reuse_.active()) order_events();
  gather_points();
  shader_->cover(points_);
  if (is_given_up()) return events_.clear();
  keep_wanted();
  events_.clear();
  const size_t estimates = shader_->estimates();
  radiance_.resize(points_.size() * estimates);
  const std::span<const RoughReflection> rough = shade_points();
  if (is_given_up()) return;
  for (size_t i = 0; i < shaded_.size(); ++i)
    sink_->add(shaded_[i].pixel, shaded_[i].layer, shaded_[i].hit, &radiance_[i * estimates], weights_[i]);
  for (size_t i = 0; i < rough.size(); ++i)
    if (rough[i].weight != glm::vec3(0.0f))
      sink_->add_rough(shaded_[i].pixel, shaded_[i].layer, points_[i], radiance_[i * estimates], rough[i]);
}

// Fills radiance_, and returns the shader's rough reflections.
std::span<const RoughReflection> LayerTracer::shade_points() {
  if (!reuse_.active()) {
    shader_->shade(points_, radiance_.data());
    return shader_->rough();
  }
  shaded_pixels_.clear();
  for (const Event& e : shaded_) shaded_pixels_.push_back(place_of(e));
  counters_->layers_borrowed += reuse_.shade(*shader_, points_, shaded_pixels_, radiance_.data());
  return reuse_.rough();
}

RayReuse::Pixel LayerTracer::place_of(const Event& event) const {
  return {requests_[event.pixel].x, requests_[event.pixel].y};
}

// Moves the surfaces of donor pixels to the front; each pixel's surfaces keep their order.
void LayerTracer::order_events() {
  std::stable_partition(events_.begin(), events_.end(), [&](const Event& e) { return place_of(e).is_donor(); });
}

// Fills points_ and shaded_ with the hits to shade.
void LayerTracer::gather_points() {
  places_.clear();
  shaded_.clear();
  for (const Event& e : events_) {
    PixelState& s = states_[e.pixel];
    if (sink_->finished(e.pixel)) {
      --s.found;
      continue;
    }
    sink_->expect(e.pixel, e.layer);
    places_.push_back({&e.hit, &s.ray, s.cone});
    shaded_.push_back(e);
  }
  if (made_points_.size() < places_.size()) made_points_.resize(places_.size());
  points_ = std::span(made_points_).first(places_.size());
  make_surfaces(*frame_->scene, *kernels_, places_, points_.data(), &frame_->view->steps());
  for (size_t i = 0; i < points_.size(); ++i)
    points_[i].key = random_key({states_[shaded_[i].pixel].key, shaded_[i].layer});
}

// Passes the precomputed light of a sprite to the sink, and returns whether it is one that has any.
bool LayerTracer::add_sprite(const Event& event, const SurfacePoint& point, glm::vec3 weight) {
  if (!frame_->sprites || frame_->scene->snapshot->instances[event.hit.instance].sprites == 0) return false;
  const glm::vec3 radiance = frame_->sprites->radiance(point.surface, event.hit);
  sink_->add(event.pixel, event.layer, event.hit, &radiance, weight);
  return true;
}

// Passes the points to the sink, and keeps those whose light it requests, with their weights.
void LayerTracer::keep_wanted() {
  weights_.clear();
  size_t kept = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Event& e = shaded_[i];
    if (sink_->finished(e.pixel)) {
      --states_[e.pixel].found;
      continue;
    }
    glm::vec3 weight(0.0f);
    const bool wanted = sink_->meet(e.pixel, points_[i], {e.hit, states_[e.pixel].ray, e.layer}, weight);
    if (!wanted || add_sprite(e, points_[i], weight)) continue;
    weights_.push_back(weight);
    // Dozens of sprites overlap, and their errors add up.
    const bool is_sprite = frame_->scene->snapshot->instances[e.hit.instance].sprites != 0;
    points_[i].weight = is_sprite ? 1.0f : points_[i].blended.cover;
    if (kept != i) {
      points_[kept] = points_[i];
      shaded_[kept] = shaded_[i];
    }
    ++kept;
  }
  points_ = points_.first(kept);
  shaded_.resize(kept);
}

}  // namespace sideray::rt
