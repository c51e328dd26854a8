#include "rt/shading/ray_reuse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "rt/base/largest.h"

namespace sideray::rt {
namespace {

// A single donor cannot disagree.
constexpr uint32_t least_donors = 2;
// A donor's shadows are reused only if its unshadowed light is within this factor of the receiver's; otherwise another
// lamp may dominate there.
constexpr float most_offered_apart = 2.0f;

struct Way {
  int x, y;
  float weight;
};
constexpr size_t most_ways = 6;
using Ways = std::array<Way, most_ways>;  // weight 0 ends the list

// Returns the offsets from a pixel with x + 2y = `rest` (mod 4) to the donors around, the nearest first. Weights fall
// with the squared distance.
constexpr Ways ways_from(int rest) {
  Ways ways{};
  size_t count = 0;
  for (int squared = 1; squared <= 5; ++squared)
    for (int y = -2; y <= 2; ++y)
      for (int x = -2; x <= 2; ++x)
        if (x * x + y * y == squared && (rest + x + 2 * y + 8) % 4 == 0 && count < most_ways)
          ways[count++] = {x, y, 1.0f / static_cast<float>(squared)};
  return ways;
}
constexpr std::array<Ways, 4> ways_to_donors{ways_from(0), ways_from(1), ways_from(2), ways_from(3)};

uint32_t side_of(const SurfacePoint& p) {
  return 2 * p.hit.instance + (p.hit.front ? 1 : 0);
}

uint32_t name_of(int x, int y) {
  return static_cast<uint32_t>(y) << 16 | static_cast<uint32_t>(x);
}

using Four = float __attribute__((vector_size(16)));

// Reads a vector and the float behind it.
Four four(const glm::vec3& first) {
  Four v;
  std::memcpy(&v, &first.x, sizeof(v));
  return v;
}

glm::vec3 three(Four v) {
  return {v[0], v[1], v[2]};
}

float dot(Four a, Four b) {
  const Four product = a * b;
  return product[0] + product[1] + product[2];
}

// Computes the mean and the range of donors' values.
struct Mean {
  Four sum{}, lowest{1e30f, 1e30f, 1e30f, 1e30f}, highest{-1e30f, -1e30f, -1e30f, -1e30f};
  float weight = 0.0f;
  uint32_t count = 0;

  void add(Four value, float share) {
    sum += share * value;
    lowest = value < lowest ? value : lowest;
    highest = highest < value ? value : highest;
    weight += share;
    ++count;
  }
  bool is_known() const { return count >= least_donors; }
  Four value() const { return sum / weight; }
  glm::vec3 apart() const { return three(highest - lowest); }
};

// Returns the visible share of the lights' unshadowed light; 1 if there is none.
glm::vec3 arriving_share(const RayAnswer& answer) {
  glm::vec3 share(1.0f);
  for (int c = 0; c < 3; ++c)
    if (answer.offered[c] > 0.0f) share[c] = answer.arrived[c] / answer.offered[c];
  return share;
}

// Collects what one point may reuse.
struct Donations {
  explicit Donations(const RayProspect& p)
      : prospect(p),
        offered(largest(p.offered)),
        wants_mirror(p.share >= least_mirror_share && !p.keeps_mirrors),
        wants_light(offered > 0.0f) {}

  const RayProspect& prospect;
  float offered;
  bool wants_mirror, wants_light;
  Mean mirrored;  // fourth component: RayAnswer::nearness
  Mean lit;

  // `shown`: a donor's mirrored radiance and its nearness, negative without a ray; `arriving`: the visible share of its
  // lights, and their largest unshadowed contribution.
  void add(Four shown, Four arriving, float weight) {
    if (shown[3] >= 0.0f) mirrored.add(shown, weight);
    const float theirs = arriving[3];
    if (!std::isfinite(theirs)) return;
    if (theirs * most_offered_apart < offered || theirs > offered * most_offered_apart) return;
    lit.add(arriving, weight);
  }

  // Sets the share of the lights, and returns how much the donors' spread changes the point's radiance.
  float reuse_lights(ReusedRays& reused) const {
    if (!wants_light) return 0.0f;
    reused.lit = lit.is_known() ? three(lit.value()) : glm::vec3(0.5f);
    return largest((lit.is_known() ? lit.apart() : glm::vec3(0.5f)) * prospect.offered);
  }
  // Does the same for mirrored radiance; returns infinity if there are too few donors.
  float reuse_mirror(ReusedRays& reused) const {
    if (!wants_mirror) return prospect.keeps_mirrors ? INFINITY : 0.0f;
    if (!mirrored.is_known()) return INFINITY;
    const Four value = mirrored.value();
    reused.has_mirror = true;
    reused.mirrored = three(value);
    reused.nearness = value[3];
    const bool met = mirrored.highest[3] > 0.0f;  // some mirror ray hit something
    return met ? largest(mirrored.apart()) * prospect.share : 0.0f;
  }
};

}  // namespace

// Holds a point that may reuse rays, for comparison with donors.
class RayReuse::Receiver {
 public:
  explicit Receiver(const SurfacePoint& point)
      : position_(four(point.position)), normal_(four(point.geometric_normal)), surface_(side_of(point)) {}

  // Returns the donor's distance from the point's plane; infinity if the donor is on another part of the surface: too
  // far from the plane, with a tolerance for the bend between the two normals.
  float off(const Donor& donor) const {
    constexpr float flat = 0.05f, most_bend = 0.5f;
    if (donor.surface != surface_) return INFINITY;
    const Four apart = four(donor.position) - position_, bend = four(donor.geometric_normal) - normal_;
    const float off = std::abs(dot(apart, normal_)), bend2 = dot(bend, bend);
    const float bound = flat + std::sqrt(bend2);
    return bend2 >= most_bend * most_bend || off * off > bound * bound * dot(apart, apart) ? INFINITY : off;
  }

 private:
  Four position_, normal_;
  uint32_t surface_;
};

RayReuse::Slot& RayReuse::slot(uint32_t pixel) {
  const size_t mask = slots_.size() - 1;
  size_t at = (pixel * 0x9e3779b1u) >> 12 & mask;
  while (slots_[at].first != none && slots_[at].pixel != pixel) at = (at + 1) & mask;
  return slots_[at];
}

void RayReuse::list_donors(std::span<const SurfacePoint> points, std::span<const Pixel> pixels) {
  slots_.assign(std::bit_ceil(2 * points.size() + 1), {0, none});
  donors_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    const uint32_t pixel = name_of(pixels[i].x, pixels[i].y);
    Slot& at = slot(pixel);
    const RayAnswer& answer = answers_[i];
    donors_[i] = {p.position,
                   side_of(p),
                   p.geometric_normal,
                   at.first,
                   answer.mirrored,
                   answer.has_mirror ? answer.nearness : -1.0f,
                   arriving_share(answer),
                   largest(answer.offered)};
    at = {pixel, static_cast<uint32_t>(i)};
  }
}

// Returns, of a pixel's donors from `first` on, the one nearest to the receiver's plane; null if there is none.
const RayReuse::Donor* RayReuse::like(const Receiver& receiver, uint32_t first) const {
  const Donor* best = nullptr;
  float least = INFINITY;
  for (uint32_t j = first; j != none; j = donors_[j].next) {
    const float off = receiver.off(donors_[j]);
    if (!(off < least)) continue;
    best = &donors_[j];
    least = off;
  }
  return best;
}

// Sets the values that the point reuses, and returns which rays they replace.
RayReuse::Reused RayReuse::reuse(const SurfacePoint& point, Pixel pixel, const RayProspect& prospect,
                                 ReusedRays& reused) {
  reused = {};
  Donations donations(prospect);
  const Receiver receiver(point);
  for (const Way& way : ways_to_donors[(pixel.x + 2u * pixel.y) % 4]) {
    const int x = pixel.x + way.x, y = pixel.y + way.y;
    if (way.weight == 0.0f || x < 0 || y < 0) continue;
    if (const Donor* donor = like(receiver, slot(name_of(x, y)).first))
      donations.add(four(donor->mirrored), four(donor->arriving), way.weight);
  }
  const float weight = point.weight, left = error_ - donations.reuse_lights(reused) * weight;
  if (!(left >= 0.0f)) return Reused::nothing;  // not finite: it is traced
  reused.traces_mirrors = !(donations.reuse_mirror(reused) * weight <= left);
  if (!reused.traces_mirrors) return Reused::all;
  reused.has_mirror = false;
  if (donations.wants_light) return Reused::lights;
  return prospect.offered == glm::vec3(0.0f) ? Reused::own_mirrors : Reused::nothing;
}

// Shades the points of alone_ with their own rays.
void RayReuse::shade_alone(PointShader& shader, std::span<const SurfacePoint> points, glm::vec3* radiance) {
  if (alone_.empty()) return;
  alone_points_.clear();
  for (const uint32_t i : alone_) alone_points_.push_back(points[i]);
  alone_radiance_.resize(alone_.size());
  shader.shade(alone_points_, alone_radiance_.data());
  const std::span<const RoughReflection> rough = shader.rough();
  for (size_t k = 0; k < alone_.size(); ++k) {
    radiance[alone_[k]] = alone_radiance_[k];
    if (!rough.empty()) rough_[alone_[k]] = rough[k];
  }
}

size_t RayReuse::shade(PointShader& shader, std::span<const SurfacePoint> points, std::span<const Pixel> pixels,
                       glm::vec3* radiance) {
  const auto donor_count =
      static_cast<size_t>(std::ranges::partition_point(pixels, [](Pixel p) { return p.is_donor(); }) - pixels.begin());
  const std::span<const SurfacePoint> donors = points.first(donor_count), receivers = points.subspan(donor_count);
  RaySharing& rays = *shader.sharing();
  shader.shade(donors, radiance);
  rough_.assign(shader.rough().begin(), shader.rough().end());
  answers_.resize(donors.size());
  rays.write_answers(answers_.data());
  if (receivers.empty()) return 0;
  list_donors(donors, pixels);
  prospects_.resize(receivers.size());
  rays.consider(receivers, prospects_.data());
  reused_.resize(receivers.size());
  alone_.clear();
  size_t reusing = 0;
  for (size_t i = 0; i < receivers.size(); ++i) {
    const Reused reused = reuse(receivers[i], pixels[donor_count + i], prospects_[i], reused_[i]);
    if (reused == Reused::nothing) alone_.push_back(static_cast<uint32_t>(donor_count + i));
    reusing += reused == Reused::lights || reused == Reused::all;
  }
  rays.shade_reusing(receivers, reused_, radiance + donor_count);
  rough_.insert(rough_.end(), shader.rough().begin(), shader.rough().end());
  shade_alone(shader, points, radiance);
  return reusing;
}

}  // namespace sideray::rt
