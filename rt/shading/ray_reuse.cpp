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

// One lender alone cannot disagree.
constexpr uint32_t least_lenders = 2;
// A lender is asked for shadows only where the lights offer about what they offer the borrower: otherwise another light
// may be the brightest there.
constexpr float most_offered_apart = 2.0f;

struct Way {
  int x, y;
  float weight;
};
constexpr size_t most_ways = 6;
using Ways = std::array<Way, most_ways>;  // weight 0: there are no more

// Returns the ways from a pixel with x + 2y = `rest` (mod 4) to the lenders around, the nearest first; weights fall
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
constexpr std::array<Ways, 4> ways_to_lenders{ways_from(0), ways_from(1), ways_from(2), ways_from(3)};

uint32_t side_of(const SurfacePoint& p) {
  return 2 * p.hit.instance + (p.hit.front ? 1 : 0);
}

uint32_t name_of(int x, int y) {
  return static_cast<uint32_t>(y) << 16 | static_cast<uint32_t>(x);
}

using Four = float __attribute__((vector_size(16)));

// Reads a vector and the number behind it.
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

// Makes a mean of what lenders say, and finds how far apart they are.
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
  bool is_known() const { return count >= least_lenders; }
  Four value() const { return sum / weight; }
  glm::vec3 apart() const { return three(highest - lowest); }
};

// Returns the share of what the lights offer that arrives; 1 where they offer nothing.
glm::vec3 arriving_share(const RayAnswer& told) {
  glm::vec3 share(1.0f);
  for (int c = 0; c < 3; ++c)
    if (told.offered[c] > 0.0f) share[c] = told.arrived[c] / told.offered[c];
  return share;
}

// Collects loans for one point.
struct Loans {
  explicit Loans(const RayProspect& p)
      : prospect(p),
        offered(largest(p.offered)),
        wants_mirror(p.share >= least_mirror_share && !p.keeps_mirrors),
        wants_light(offered > 0.0f) {}

  const RayProspect& prospect;
  float offered;
  bool wants_mirror, wants_light;
  Mean mirrored;  // the fourth is RayAnswer::nearness
  Mean lit;

  // `shown`: what a lender's mirror shows, and its nearness, negative without a ray; `arriving`: the share of its
  // lights, and the greatest of what they offer.
  void add(Four shown, Four arriving, float weight) {
    if (shown[3] >= 0.0f) mirrored.add(shown, weight);
    const float theirs = arriving[3];
    if (!std::isfinite(theirs)) return;
    if (theirs * most_offered_apart < offered || theirs > offered * most_offered_apart) return;
    lit.add(arriving, weight);
  }

  // Fills the loan of lights, and returns by how much lenders disagree on what it adds to the point's radiance.
  float lend_lights(RayLoan& loan) const {
    if (!wants_light) return 0.0f;
    loan.lit = lit.is_known() ? three(lit.value()) : glm::vec3(0.5f);
    return largest((lit.is_known() ? lit.apart() : glm::vec3(0.5f)) * prospect.offered);
  }
  // Does the same with what the mirror shows; infinity where too few lend.
  float lend_mirror(RayLoan& loan) const {
    if (!wants_mirror) return prospect.keeps_mirrors ? INFINITY : 0.0f;
    if (!mirrored.is_known()) return INFINITY;
    const Four value = mirrored.value();
    loan.has_mirror = true;
    loan.mirrored = three(value);
    loan.nearness = value[3];
    const bool met = mirrored.highest[3] > 0.0f;  // some mirror ray hit something
    return met ? largest(mirrored.apart()) * prospect.share : 0.0f;
  }
};

}  // namespace

// A point that asks for loans, as it is compared with lenders.
class RayReuse::Borrower {
 public:
  explicit Borrower(const SurfacePoint& point)
      : position_(four(point.position)), normal_(four(point.geometric_normal)), surface_(side_of(point)) {}

  // Returns how far the lender is off the point's plane; infinity where it is not on the same part of the point's
  // surface: near its plane, but for the deviation that a curve through both explains.
  float off(const Lender& lender) const {
    constexpr float flat = 0.05f, most_bend = 0.5f;
    if (lender.surface != surface_) return INFINITY;
    const Four apart = four(lender.position) - position_, bend = four(lender.geometric_normal) - normal_;
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

void RayReuse::list_lenders(std::span<const SurfacePoint> points, std::span<const Pixel> pixels) {
  slots_.assign(std::bit_ceil(2 * points.size() + 1), {0, none});
  lenders_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    const uint32_t pixel = name_of(pixels[i].x, pixels[i].y);
    Slot& at = slot(pixel);
    const RayAnswer& told = told_[i];
    lenders_[i] = {p.position,
                   side_of(p),
                   p.geometric_normal,
                   at.first,
                   told.mirrored,
                   told.has_mirror ? told.nearness : -1.0f,
                   arriving_share(told),
                   largest(told.offered)};
    at = {pixel, static_cast<uint32_t>(i)};
  }
}

// Returns the lender of a pixel, whose first is `first`, that is least off the borrower's plane; null where none lends.
const RayReuse::Lender* RayReuse::like(const Borrower& borrower, uint32_t first) const {
  const Lender* best = nullptr;
  float least = INFINITY;
  for (uint32_t j = first; j != none; j = lenders_[j].next) {
    const float off = borrower.off(lenders_[j]);
    if (!(off < least)) continue;
    best = &lenders_[j];
    least = off;
  }
  return best;
}

// Fills the point's loan, and says what of its rays it stands for.
RayReuse::Lent RayReuse::borrow(const SurfacePoint& point, Pixel pixel, const RayProspect& prospect, RayLoan& loan) {
  loan = {};
  Loans loans(prospect);
  const Borrower borrower(point);
  for (const Way& way : ways_to_lenders[(pixel.x + 2u * pixel.y) % 4]) {
    const int x = pixel.x + way.x, y = pixel.y + way.y;
    if (way.weight == 0.0f || x < 0 || y < 0) continue;
    if (const Lender* lender = like(borrower, slot(name_of(x, y)).first))
      loans.add(four(lender->mirrored), four(lender->arriving), way.weight);
  }
  const float cover = point.blended.cover, left = error_ - loans.lend_lights(loan) * cover;
  if (!(left >= 0.0f)) return Lent::nothing;  // what is not finite is traced
  loan.traces_mirrors = !(loans.lend_mirror(loan) * cover <= left);
  if (!loan.traces_mirrors) return Lent::all;
  loan.has_mirror = false;
  if (loans.wants_light) return Lent::lights;
  return prospect.offered == glm::vec3(0.0f) ? Lent::own_mirrors : Lent::nothing;
}

// Shades the points of unlent_ by rays of their own.
void RayReuse::shade_unlent(PointShader& shader, std::span<const SurfacePoint> points, glm::vec3* radiance) {
  if (unlent_.empty()) return;
  unlent_points_.clear();
  for (const uint32_t i : unlent_) unlent_points_.push_back(points[i]);
  unlent_radiance_.resize(unlent_.size());
  shader.shade(unlent_points_, unlent_radiance_.data());
  const std::span<const RoughReflection> rough = shader.rough();
  for (size_t k = 0; k < unlent_.size(); ++k) {
    radiance[unlent_[k]] = unlent_radiance_[k];
    if (!rough.empty()) rough_[unlent_[k]] = rough[k];
  }
}

size_t RayReuse::shade(PointShader& shader, std::span<const SurfacePoint> points, std::span<const Pixel> pixels,
                       glm::vec3* radiance) {
  const auto lending =
      static_cast<size_t>(std::ranges::partition_point(pixels, [](Pixel p) { return p.lends(); }) - pixels.begin());
  const std::span<const SurfacePoint> lenders = points.first(lending), borrowers = points.subspan(lending);
  RayLending& rays = *shader.lending();
  shader.shade(lenders, radiance);
  rough_.assign(shader.rough().begin(), shader.rough().end());
  told_.resize(lenders.size());
  rays.tell(told_.data());
  if (borrowers.empty()) return 0;
  list_lenders(lenders, pixels);
  prospects_.resize(borrowers.size());
  rays.consider(borrowers, prospects_.data());
  loans_.resize(borrowers.size());
  unlent_.clear();
  size_t borrowing = 0;
  for (size_t i = 0; i < borrowers.size(); ++i) {
    const Lent lent = borrow(borrowers[i], pixels[lending + i], prospects_[i], loans_[i]);
    if (lent == Lent::nothing) unlent_.push_back(static_cast<uint32_t>(lending + i));
    borrowing += lent == Lent::lights || lent == Lent::all;
  }
  rays.lend(borrowers, loans_, radiance + lending);
  rough_.insert(rough_.end(), shader.rough().begin(), shader.rough().end());
  shade_unlent(shader, points, radiance);
  return borrowing;
}

}  // namespace sideray::rt
