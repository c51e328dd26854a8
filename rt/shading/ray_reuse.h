// Shades points, some of them with rays of other points. One pixel in four is a donor and traces rays; the pixels
// around reuse its rays on the same surface if all their donors agree. A point without donors traces its own rays, and
// one whose donors agree only on lights traces its own mirror rays. Surfaces, textures, normals, unshadowed lights and
// cover are computed at every point. Only mirrored radiance and the visible share of lights are reused: they change
// slowly over a surface, and where they do not, donors disagree. It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/shading/point_shader.h"
#include "rt/shading/ray_sharing.h"

namespace sideray::rt {

class RayReuse {
 public:
  struct Pixel {
    uint16_t x, y;
    // Returns whether the pixel is a donor, whose points always trace rays.
    bool is_donor() const { return (x + 2u * y) % 4 == 0; }
  };

  // `error`: the maximum spread among donors in a point's contribution to its pixel; 0 = every point traces its own
  // rays.
  void begin(float error) { error_ = error; }
  bool active() const { return error_ > 0.0f; }

  // Writes the outgoing light of the points, of which those of donor pixels must come first. Returns how many points
  // reused rays. `shader` must support sharing().
  size_t shade(PointShader& shader, std::span<const SurfacePoint> points, std::span<const Pixel> pixels,
               glm::vec3* radiance);
  // Returns PointShader::rough() of the points of shade().
  std::span<const RoughReflection> rough() const { return rough_; }

 private:
  // Holds a donor's surface and its rays' results: one cache line, read four numbers at once.
  struct alignas(64) Donor {
    glm::vec3 position;
    uint32_t surface;  // instance and side
    glm::vec3 geometric_normal;
    uint32_t next;       // donor in the same pixel, or none
    glm::vec3 mirrored;  // as in RayAnswer
    float nearness;      // as in RayAnswer; negative = no mirror ray was traced
    // For its lights: the visible share of their unshadowed light, and that light's largest channel.
    glm::vec3 arriving;
    float offered;
  };
  class Receiver;
  struct Slot {
    uint32_t pixel, first;  // first donor in the pixel, or none
  };
  static constexpr uint32_t none = 0xffffffffu;

  void list_donors(std::span<const SurfacePoint> points, std::span<const Pixel> pixels);
  Slot& slot(uint32_t pixel);
  const Donor* like(const Receiver& receiver, uint32_t first) const;
  // `own_mirrors`: no light reaches the point, and it traces its own mirror rays; `nothing`: it must be shaded with its
  // own rays.
  enum class Reused { nothing, own_mirrors, lights, all };
  Reused reuse(const SurfacePoint& point, Pixel pixel, const RayProspect& prospect, ReusedRays& reused);
  void shade_alone(PointShader& shader, std::span<const SurfacePoint> points, glm::vec3* radiance);

  float error_ = 0.0f;
  std::vector<Donor> donors_;
  std::vector<Slot> slots_;  // a hash table of pixels
  std::vector<RayAnswer> answers_;
  std::vector<RayProspect> prospects_;
  std::vector<ReusedRays> reused_;
  std::vector<uint32_t> alone_;  // points without usable donors
  std::vector<SurfacePoint> alone_points_;
  std::vector<glm::vec3> alone_radiance_;
  std::vector<RoughReflection> rough_;
};

}  // namespace sideray::rt
