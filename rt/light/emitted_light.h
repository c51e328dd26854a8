// Adds the light of emissive surfaces to diffuse points, by one sampled point of a surface each with a shadow ray, which
// translucent surfaces tint. Random rays that hit an emitter find the same light; share_of_hit() weights them (Veach
// 1995). It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/embree/intersector.h"
#include "rt/light/emitters.h"
#include "rt/light/straight_light.h"

namespace sideray::rt {

class EmittedLight {
 public:
  // The caller keeps both objects alive.
  void begin(const ShadingScene& scene, const Intersector& intersector);
  // Returns whether the scene has emitters; the other functions require them.
  bool is_sampled() const { return scene_->emitters && !scene_->emitters->get().empty(); }

  struct Answer {
    uint32_t number;
    glm::vec3 light;
    float distance;
  };
  // Begins a group of points. Of neighbours in it, an even share is sampled.
  void begin_group(uint32_t key) { lot_ = unit_float(hash_bits(key)); }
  // Samples an emitter for a point with a probability. If it is visible, finish() returns an estimate of the radiance of
  // all emitters, averaged over the cosine, times `gain`. `key` is for random numbers.
  void add(const LitPoint& point, float probability, glm::vec3 gain, uint32_t number, uint32_t key);
  // Returns the light of the emitters sampled since the last call; it stays valid until the next one.
  std::span<const Answer> finish();
  // Returns the weight of emission that a ray from the point hits, whose direction was sampled by the cosine.
  // `probability`: as in add() for this point.
  float share_of_hit(const LitPoint& point, float probability, const Hit& hit, glm::vec3 direction) const;

  uint64_t rays = 0;  // traversals since begin()

 private:
  struct Sampled {
    Hit hit;
    Ray ray;  // ends at the hit
    glm::vec3 gain;
    uint32_t number;
  };
  void drop_blocked();
  bool is_translucent(const Hit& hit) const;

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  StraightLight straight_;
  float lot_ = 0.0f;  // the point with which it reaches 1 is sampled
  std::vector<Sampled> sampled_;
  std::vector<Ray> rays_;
  std::vector<uint8_t> blocked_;
  std::vector<HitPlace> places_;
  std::vector<SurfacePoint> points_;
  std::vector<Answer> answers_;
};

}  // namespace sideray::rt
