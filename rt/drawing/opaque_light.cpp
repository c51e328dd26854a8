#include "rt/drawing/opaque_light.h"

#include <half.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "rt/base/view_rays.h"
#include "rt/drawing/view_tile.h"
#include "rt/light/direct_light.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

glm::vec3 vector_of_halfs(const uint16_t* halfs) {
  return {imath_half_to_float(halfs[0]), imath_half_to_float(halfs[1]), imath_half_to_float(halfs[2])};
}

constexpr uint32_t first_combined_light = 32;
constexpr size_t enough_rays = 1024;  // for full packets across lights, as in HitShader

struct LightWorker {
  ViewTile tile;
  std::vector<HitPlace> places;
  std::vector<uint32_t> texels;  // of `places`
  std::vector<Hit> thin;         // thin hits of `places`, renamed to their records
  std::vector<glm::vec3> radiance;
  std::vector<SkyShares> sky;
  SurfaceBatch batch;
  DirectLight direct;
  Counters counters;
};

// Refers to the masks of one light: its visible share, and its tint.
struct LightMask {
  std::span<const uint8_t> lit;      // empty: the light has no mask
  std::span<const uint8_t> tint[3];  // empty: no tint
};

// Masks have eight bits.
float mask_share(uint8_t value) {
  return static_cast<float>(value) / 255.0f;
}

glm::vec3 arriving_share(const LightMask& mask, uint32_t texel) {
  glm::vec3 arriving(mask_share(mask.lit[texel]));
  if (!mask.tint[0].empty())
    for (int c = 0; c < 3; ++c) arriving[c] *= mask_share(mask.tint[c][texel]);
  return arriving;
}

class LightPass {
 public:
  LightPass(const OpaqueLightRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture)
      : request_(request),
        pixels_(*request.pixels),
        scene_(scene.shading()),
        intersector_(scene.intersector()),
        view_(request.view, pixels_.width, pixels_.height),
        picture_(picture) {
    for (const uint32_t number : scene_.light_numbers) masks_.push_back(mask_of(number));
  }

  void light(size_t index, LightWorker& w) {
    w.tile.list(pixels_.width, pixels_.height, index);
    if (fill_empty(w.tile)) return;
    w.tile.aim(view_);
    list(w);
    if (w.places.empty()) return;
    w.batch.begin(scene_, intersector_.isa());
    w.batch.load_drawn(w.places, view_.steps());
    look_around(w);
    w.radiance.resize(w.places.size());
    w.batch.finish(w.radiance.data());
    add_lights(w);
    for (size_t i = 0; i < w.texels.size(); ++i) picture_[w.texels[i]] = {w.radiance[i], 1.0f};
  }

 private:
  LightMask mask_of(uint32_t number) const {
    LightMask mask;
    if (!request_.masks) return mask;
    uint32_t layer = 0;
    if (number < first_combined_light) {
      if ((request_.shadow_lights >> number & 1u) == 0) return mask;
      layer = static_cast<uint32_t>(std::popcount(request_.shadow_lights & ((1u << number) - 1u)));
    } else {
      if (!request_.combined_lights) return mask;
      layer = static_cast<uint32_t>(std::popcount(request_.shadow_lights));
    }
    const OcclusionMasks& masks = *request_.masks;
    mask.lit = plane(masks, layer);
    const uint32_t place = masks.tints > 0 ? masks.tint_places[layer] : 0;
    if (place != 0 && masks.is_tinted(place))
      for (uint32_t c = 0; c < 3; ++c) mask.tint[c] = masks.tint_plane(place, c);
    return mask;
  }

  static std::span<const uint8_t> plane(const OcclusionMasks& masks, uint32_t layer) {
    const size_t pixels = size_t{masks.width} * masks.height;
    return std::span(masks.lit).subspan(layer * pixels, pixels);
  }

  size_t texel_of(glm::uvec2 pixel) const { return size_t{pixel.y} * pixels_.width + pixel.x; }

  // Fills a tile that shows uniform surroundings alone, without rays. Returns false if it shows anything else.
  bool fill_empty(const ViewTile& tile) const {
    const model::Environment& environment = *scene_.snapshot->environment;
    const auto is_empty = [&](glm::uvec2 p) { return pixels_.hits[texel_of(p)].instance == no_instance; };
    if (!is_uniform(environment) || !std::ranges::all_of(tile.pixels, is_empty)) return false;
    const glm::vec4 seen(environment_specular(environment, glm::vec3(0.0f), 0.0f), 0.0f);
    for (const glm::uvec2 p : tile.pixels) picture_[texel_of(p)] = seen;
    return true;
  }

  // Lists the pixels that show a surface, and fills the others with the sky.
  void list(LightWorker& w) {
    w.places.clear();
    w.texels.clear();
    w.thin.clear();
    w.thin.reserve(w.tile.pixels.size());  // `places` points into it
    for (size_t i = 0; i < w.tile.pixels.size(); ++i) {
      const auto texel = static_cast<uint32_t>(texel_of(w.tile.pixels[i]));
      const Hit& hit = pixels_.hits[texel];
      if (hit.instance == no_instance) {
        picture_[texel] = {environment_specular(*scene_.snapshot->environment, w.tile.rays[i].direction, 0.0f), 0.0f};
        continue;
      }
      const Hit* named = &hit;
      if (is_thin(hit)) {
        named = &w.thin.emplace_back(hit);
        w.thin.back().instance = record_of(hit, *scene_.snapshot);
      }
      w.places.push_back({named, &w.tile.rays[i], w.tile.cones[i]});
      w.texels.push_back(texel);
    }
  }

  void look_around(LightWorker& w) const {
    if (request_.sky) hide_sky(w);
    if (request_.bounced) add_bounced(w);
    w.batch.reflect_environment();
    if (request_.bounced) put_under_cover(w);
    if (!request_.mirrored) return;
    const std::span<AroundBlock> around = w.batch.around();
    for (size_t i = 0; i < w.texels.size(); ++i) {
      const uint16_t* halfs = &request_.mirrored->radiance[size_t{4} * w.texels[i]];
      AroundBlock& a = around[i / block_size];
      const size_t lane = i % block_size;
      // Reflection rays sample only isotropic lobes.
      if (halfs[3] == 0 || (a.brushed >> lane & 1u) != 0) continue;
      const glm::vec3 seen = vector_of_halfs(halfs);
      set_vector(a.specular, lane, glm::mix(vector_at(a.specular, lane), seen, imath_half_to_float(halfs[3])));
    }
  }

  // Adds light from other surfaces to the visible share of the sky's light, to which hide_sky() then adds none by way
  // of occluders. Occlusion textures have no effect there: rays have found what they stand in for.
  void add_bounced(LightWorker& w) const {
    const std::span<AroundBlock> around = w.batch.around();
    for (size_t i = 0; i < w.texels.size(); ++i) {
      const uint16_t* halfs = &request_.bounced->light[size_t{4} * w.texels[i]];
      if (halfs[3] == 0) continue;
      AroundBlock& a = around[i / block_size];
      const glm::vec3 light = vector_of_halfs(halfs);
      set_vector(a.irradiance, i % block_size, glm::max(vector_at(a.irradiance, i % block_size) + light, 0.0f));
      w.batch.drop_occlusion(i);
    }
  }

  // Gives rough lobes, coats and diffuse transmission the same light as diffuse reflection: the open share of the sky,
  // and for the rest the average arriving light.
  void put_under_cover(LightWorker& w) const {
    const std::span<AroundBlock> around = w.batch.around();
    for (size_t i = 0; i < w.texels.size(); ++i) {
      const uint16_t* halfs = &request_.bounced->light[size_t{4} * w.texels[i]];
      if (halfs[3] == 0) continue;
      AroundBlock& a = around[i / block_size];
      const glm::vec3 light = vector_of_halfs(halfs);
      const float open = request_.sky ? mask_share(request_.masks->open[w.texels[i]]) : 1.0f;
      for (BlockRow(*rows)[3] : {&a.specular, &a.coat, &a.behind})
        set_vector(*rows, i % block_size, glm::max(vector_at(*rows, i % block_size) * open + light, 0.0f));
    }
  }

  void hide_sky(LightWorker& w) const {
    const OcclusionMasks& masks = *request_.masks;
    const std::span<const uint8_t> unhidden =
        request_.unhidden_sky ? plane(masks, light_masks_of(request_.shadow_lights, request_.combined_lights))
                              : std::span(masks.open);
    w.sky.resize(w.batch.around().size());
    for (size_t i = 0; i < w.sky.size() * block_size; ++i) {
      const uint32_t texel = w.texels[std::min(i, w.texels.size() - 1)];
      w.sky[i / block_size].open[i % block_size] = mask_share(masks.open[texel]);
      const bool is_lit = request_.bounced && request_.bounced->light[size_t{4} * texel + 3] != 0;
      w.sky[i / block_size].unhidden[i % block_size] = is_lit ? 1.0f : mask_share(unhidden[texel]);
    }
    w.batch.hide_sky(w.sky);
  }

  void add_lights(LightWorker& w) {
    w.direct.begin(scene_, intersector_);
    w.direct.clear();
    for (size_t k = 0; k < scene_.lights.size(); ++k) {
      if (!masks_[k].lit.empty()) {
        add_masked(scene_.lights[k], masks_[k], w);
        continue;
      }
      w.direct.gather(w.batch, k);
      if (w.direct.rays() >= enough_rays) trace_shadows(w);
    }
    trace_shadows(w);
  }

  void add_masked(const shading::SrLight& light, const LightMask& mask, LightWorker& w) const {
    LightBlock found;
    std::array<glm::vec3, block_size> arriving;
    for (size_t first = 0; first < w.texels.size(); first += block_size) {
      const size_t count = std::min<size_t>(block_size, w.texels.size() - first);
      uint32_t lit = 0;
      for (size_t i = 0; i < count; ++i) {
        arriving[i] = arriving_share(mask, w.texels[first + i]);
        lit |= uint32_t{arriving[i] != glm::vec3(0.0f)} << i;
      }
      if (lit == 0) continue;
      w.batch.light(first / block_size, light, found);
      for (uint32_t bits = found.reached & lit; bits != 0; bits &= bits - 1) {
        const auto i = static_cast<size_t>(std::countr_zero(bits));
        w.radiance[first + i] += vector_at(found.gain, i) * arriving[i];
      }
    }
  }

  void trace_shadows(LightWorker& w) const {
    if (w.direct.rays() == 0) return;
    if (request_.shadows) w.counters.rays_shadow += w.direct.rays();
    w.direct.add(request_.shadows ? &intersector_ : nullptr, w.radiance.data(), true);
    w.direct.clear();
  }

  const OpaqueLightRequest& request_;
  const OpaquePixels& pixels_;
  const ShadingScene& scene_;
  const Intersector& intersector_;
  ViewRays view_;
  std::vector<LightMask> masks_;  // by light of the scene
  std::vector<glm::vec4>& picture_;
};

}  // namespace

Counters light_opaque_pixels(const OpaqueLightRequest& request, TracedScene& scene, std::vector<glm::vec4>& picture) {
  const uint32_t width = request.pixels->width, height = request.pixels->height;
  picture.resize(size_t{width} * height);
  LightPass pass(request, scene, picture);
  std::vector<LightWorker> workers(scene.executor().threads());
  scene.executor().run(ViewTile::tiles_in(width, height),
                       [&](size_t tile, uint32_t thread) { pass.light(tile, workers[thread]); });
  Counters counters;
  for (const LightWorker& worker : workers) counters += worker.counters;
  return counters;
}

}  // namespace sideray::rt
