// Shades points of which only some trace rays. One pixel of four does; what its rays told is lent to the same surface
// in the pixels around, as long as all that lend agree; who gets no loan, or only one of lights, traces after all.
// Surfaces, textures, normals, unblocked lights and cover are computed at every point: only what mirrors show and the
// share of the lights that arrives are lent. So nothing blurs but what moves slowly over the surface, and where it does
// not, lenders differ. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/shading/point_shader.h"
#include "rt/shading/ray_lending.h"

namespace sideray::rt {

class RayReuse {
 public:
  struct Pixel {
    uint16_t x, y;
    // Returns whether the pixel's points trace rays in any case, and lend what these tell.
    bool lends() const { return (x + 2u * y) % 4 == 0; }
  };

  // `error`: by how much lenders may disagree on what a point adds to its pixel; 0 = every point traces its own rays.
  void begin(float error) { error_ = error; }
  bool active() const { return error_ > 0.0f; }

  // Writes the light that leaves the points; those of pixels that lend come first. Returns how many points borrowed
  // something.
  // `shader` is one that lends.
  size_t shade(PointShader& shader, std::span<const SurfacePoint> points, std::span<const Pixel> pixels,
               glm::vec3* radiance);
  // Returns what PointShader::rough() would say of the points of shade().
  std::span<const RoughReflection> rough() const { return rough_; }

 private:
  // Holds a lender's surface, for comparison, and what its rays told: one cache line, read four numbers at once.
  struct alignas(64) Lender {
    glm::vec3 position;
    uint32_t surface;  // instance and side
    glm::vec3 geometric_normal;
    uint32_t next;       // lender in the same pixel, or none
    glm::vec3 mirrored;  // as in RayAnswer
    float nearness;      // likewise; negative = no mirror ray was traced
    // What borrowers ask of its lights: the share of what they offer that arrives, and the greatest of what they offer.
    glm::vec3 arriving;
    float offered;
  };
  class Borrower;
  struct Slot {
    uint32_t pixel, first;  // first lender there, or none
  };
  static constexpr uint32_t none = 0xffffffffu;

  void list_lenders(std::span<const SurfacePoint> points, std::span<const Pixel> pixels);
  Slot& slot(uint32_t pixel);
  const Lender* like(const Borrower& borrower, uint32_t first) const;
  // `own_mirrors`: no light reaches the point, and it traces its mirrors' rays where others borrow; `nothing`: it has to
  // be shaded anew.
  enum class Lent { nothing, own_mirrors, lights, all };
  Lent borrow(const SurfacePoint& point, Pixel pixel, const RayProspect& prospect, RayLoan& loan);
  void shade_unlent(PointShader& shader, std::span<const SurfacePoint> points, glm::vec3* radiance);

  float error_ = 0.0f;
  std::vector<Lender> lenders_;
  std::vector<Slot> slots_;  // a hash table of pixels
  std::vector<RayAnswer> told_;
  std::vector<RayProspect> prospects_;
  std::vector<RayLoan> loans_;
  std::vector<uint32_t> unlent_;  // points that nobody lends to
  std::vector<SurfacePoint> unlent_points_;
  std::vector<glm::vec3> unlent_radiance_;
  std::vector<RoughReflection> rough_;
};

}  // namespace sideray::rt
