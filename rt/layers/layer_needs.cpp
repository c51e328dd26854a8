#include "rt/layers/layer_needs.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

constexpr float least_brightness = 16.0f;
constexpr float least_weight = 1e-6f;
// This is twice what rasterization moves an edge by with four bits below the pixel, the fewest that OpenGL allows.
constexpr float edge_px = 0.0625f;
// This is a share of the distance: surfaces nearer to each other, or to the ray's end, may be drawn in another order.
constexpr float relative_margin = 0x1p-10f;
// Rasterizer and rays may disagree by this much in the transmittance of a surface without textures.
constexpr float through_margin = 0x1p-6f;

float largest(glm::vec3 v) {
  return std::max({v.x, v.y, v.z});
}

glm::vec3 to_vec3(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

float brightest_texel(const model::Environment& environment) {
  float brightest = 0.0f;
  if (environment.black) return brightest;
  for (const glm::vec3& texel : environment.specular.front().texels) brightest = std::max(brightest, largest(texel));
  return brightest;
}

float brightest_content(const model::Snapshot& snapshot) {
  float brightest = least_brightness;
  for (const model::Material& m : snapshot.materials)
    brightest = std::max(brightest, largest(to_vec3(m.desc.emissive)));
  return brightest;
}

float cover_of(const SurfacePoint& p) {
  return p.answer ? p.answer->blend.cover : shading::sr_blend(p.surface, p.to_eye, p.blend).cover;
}

// Returns by how much the distance of a surface changes within the edge of a pixel, with rounding.
float depth_margin(const SurfacePoint& p, float distance) {
  const float facing = std::max(std::abs(glm::dot(p.geometric_normal, p.to_eye)), 1e-3f);
  return p.cone.width * edge_px / facing + relative_margin * distance;
}

}  // namespace

bool is_off_edges(const ShadingScene& scene, const Hit& hit, const Ray& ray, float near) {
  const model::Instance& instance = scene.snapshot->instances[hit.instance];
  const model::Mesh& mesh = *scene.snapshot->meshes[instance.mesh];
  const glm::uvec3 t = mesh.triangles[hit.primitive];
  const glm::mat3 linear(instance.local_from_object);
  const auto seen = [&](glm::vec3 edge) {
    const glm::vec3 e = linear * edge;
    return e - ray.direction * glm::dot(e, ray.direction);
  };
  const glm::vec3 e1 = seen(mesh.positions[t.y] - mesh.positions[t.x]);
  const glm::vec3 e2 = seen(mesh.positions[t.z] - mesh.positions[t.x]);
  const float area = glm::length(glm::cross(e1, e2));
  return hit.u * area > near * glm::length(e2) && hit.v * area > near * glm::length(e1) &&
         (1.0f - hit.u - hit.v) * area > near * glm::length(e2 - e1);
}

namespace {

// Returns whether the rasterizer is sure to draw the surface at this pixel, with the transmittance that the ray found.
bool is_sure(const ShadingScene& scene, const Hit& hit, const Ray& ray, const SurfacePoint& p, float margin) {
  const model::Instance& instance = scene.snapshot->instances[hit.instance];
  if (instance.sprites != 0 || instance.wind != 0) return false;
  const bool plain = scene.textures[instance.material].empty() &&
                     scene.snapshot->materials[instance.material].desc.alpha_mode != SIDERAY_MASK;
  return plain && static_cast<float>(hit.distance) + margin < ray.t_far && is_off_edges(scene, hit, ray, edge_px * p.cone.width);
}

}  // namespace

void LayerNeeds::begin(const FrameContext& frame, size_t pixels) {
  frame_ = &frame;
  threshold_ = frame.layer_threshold;
  // Answers that other pixels or later frames take have other weights there.
  const bool known = frame.cache && frame.cache->cache_rate == SIDERAY_RATE_FULL;
  weights_ = known ? frame.cache->weights : LayerWeights::unknown;
  if (!active() || !frame.cache) return;
  covers_.resize(pixels);
  for (PixelCovers& covers : covers_) covers.count = 0;
}

// Returns a layer's share of the threshold. Where the number of layers is unknown, the shares add up to 1 however many
// there are.
float LayerNeeds::share(const PixelRequest& request, uint32_t layer) const {
  if (frame_->cache && weights_ == LayerWeights::unknown)
    return threshold_ / static_cast<float>(frame_->request->max_layers);
  if (request.layers != unlimited_layers) return threshold_ / static_cast<float>(request.layers);
  return threshold_ / (static_cast<float>(layer + 1) * static_cast<float>(layer + 2));
}

// Returns an instance's place in the drawing order. The inner side of a two-sided object is drawn before the outer one.
uint32_t LayerNeeds::drawn(const Hit& hit) const {
  return 2 * frame_->cache->drawn[hit.instance] + (hit.front ? 1 : 0);
}

glm::vec3 LayerNeeds::attenuation(const PixelCovers& covers, uint32_t drawn, float distance, float margin) const {
  glm::vec3 through(1.0f);
  for (uint32_t i = 0; i < covers.count; ++i) {
    const Cover& c = covers.covers[i];
    const bool nearer = c.distance + c.margin + margin < distance;
    // A whole pixel is composited in the order along the ray, whatever object is drawn first.
    const bool attenuates =
        weights_ == LayerWeights::objects ? c.drawn > drawn && (nearer || !frame_->cache->whole_pixels) : nearer;
    if (attenuates) through *= c.through;
  }
  return through;
}

float LayerNeeds::weight_in_cache(const PixelRequest& request, const Met& met) {
  if (weights_ == LayerWeights::unknown) return 1.0f;
  const ShadingScene& scene = *frame_->scene;
  const SurfacePoint& p = *met.point;
  const uint32_t material = scene.snapshot->instances[met.hit->instance].material;
  const bool has_textures = !scene.textures[material].empty();
  const float cover = has_textures ? 1.0f : cover_of(p);
  PixelCovers& covers = covers_[met.pixel];
  // Most pixels have one layer, which nothing attenuates and which attenuates nothing.
  const bool is_last = met.layer + 1 >= request.layers;
  if (weights_ == LayerWeights::covers || (is_last && covers.count == 0)) return cover;
  const auto distance = static_cast<float>(met.hit->distance);
  const float margin = depth_margin(p, distance);
  const uint32_t place = weights_ == LayerWeights::objects ? drawn(*met.hit) : 0;
  const float weight = cover * largest(attenuation(covers, place, distance, margin));
  if (!is_last && covers.count < most_in_front && is_sure(scene, *met.hit, *met.ray, p, margin))
    covers.covers[covers.count++] = {place, distance, margin, glm::min(blend_of(p).through + through_margin, 1.0f)};
  return weight;
}

float LayerNeeds::allowance(const PixelRequest& request, const Met& met) {
  const float weight = frame_->cache ? weight_in_cache(request, met) : largest(met.weight);
  return share(request, met.layer) / std::max(weight, least_weight);
}

float BrightestMirrored::of(const model::Snapshot& snapshot) {
  if (measured_ != snapshot.environment) environment_ = brightest_texel(*snapshot.environment);
  measured_ = snapshot.environment;
  return std::max(environment_, brightest_content(snapshot));
}

float brightest_mirrored(const model::Snapshot& snapshot) {
  return std::max(brightest_texel(*snapshot.environment), brightest_content(snapshot));
}

}  // namespace sideray::rt
