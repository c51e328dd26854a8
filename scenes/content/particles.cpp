#include "scenes/content/particles.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <iterator>

#include "elementary/functions.h"
#include "scenes/base/limits.h"
#include "scenes/content/content.h"
#include "scenes/content/hash.h"

namespace sideray::scenes {
namespace {

// Names the uses of a particle's random numbers.
enum Purpose : uint32_t {
  for_birth,
  for_lifetime,
  for_place,  // three
  for_spread = for_place + 3,
  for_turbulence = for_spread + 3,  // six
  for_size = for_turbulence + 6,
  for_rotation,
  for_spin,
  for_frame,
  purposes
};

// Identifies one of the particles that follow each other in a slot, by its generation.
struct Life {
  uint32_t seed, slot, generation;
  double age, length;
  double random(uint32_t purpose) const {
    return static_cast<double>(hash01(slot, generation * purposes + purpose, seed));
  }
  double random(uint32_t purpose, Range range) const { return range.low + (range.high - range.low) * random(purpose); }
  double share() const { return age / length; }
};

// Interpolates linearly between evenly spaced keys.
template <typename T>
T over_life(const std::vector<T>& keys, double share) {
  const double at = share * static_cast<double>(keys.size() - 1);
  const size_t first = std::min(static_cast<size_t>(at), keys.size() - 1),
               second = std::min(first + 1, keys.size() - 1);
  return keys[first] + (keys[second] - keys[first]) * (at - static_cast<double>(first));
}

// Returns a point of a ball, uniformly distributed.
glm::dvec3 in_ball(const Life& life, uint32_t purpose, double radius) {
  const double z = 2 * life.random(purpose) - 1, turn = glm::two_pi<double>() * life.random(purpose + 1);
  const double flat = std::sqrt(std::max(0.0, 1 - z * z));
  return radius * elementary::cbrt(life.random(purpose + 2)) * glm::dvec3(flat * elementary::cos(turn), flat * elementary::sin(turn), z);
}

struct Motion {
  glm::dvec3 place, velocity;  // at birth, in the node's space
};

Motion birth(const Particles& p, const Life& life) {
  Motion m{glm::dvec3(0), p.velocity + in_ball(life, for_spread, p.spread)};
  switch (p.start) {
    case Particles::Start::point:
      break;
    case Particles::Start::box:
      for (int c = 0; c < 3; ++c) m.place[c] = p.box[c] * (life.random(for_place + static_cast<uint32_t>(c)) - 0.5);
      break;
    case Particles::Start::sphere:
      m.place = in_ball(life, for_place, p.radius);
      break;
    case Particles::Start::cone: {
      const double turn = glm::two_pi<double>() * life.random(for_place), r = std::sqrt(life.random(for_place + 1));
      const glm::dvec3 outward(elementary::cos(turn), 0, elementary::sin(turn));
      m.place = p.radius * r * outward;
      m.velocity += outward * (r * glm::length(p.velocity) * elementary::tan(glm::radians(p.cone_deg)));
      break;
    }
  }
  return m;
}

// Holds the distances that a unit of velocity and a unit of acceleration move a particle with drag: the solution of
// x'' = a - k x'.
struct Carried {
  double by_velocity, by_acceleration;
};

Carried carried(double age, double drag) {
  const double lost = drag * age;
  // For small values the differences below cancel; two terms of the series are exact to 1e-9.
  if (lost < 1e-4) return {age * (1 - lost / 2), age * age / 2 * (1 - lost / 3)};
  const double by_velocity = -elementary::expm1(-lost) / drag;
  return {by_velocity, (age - by_velocity) / drag};
}

// Returns the sum of two waves along each axis, which have the particle's own phases and grow from 0.
glm::dvec3 turbulence(const Particles& p, const Life& life) {
  if (p.turbulence <= 0) return glm::dvec3(0);
  glm::dvec3 offset(0);
  for (int c = 0; c < 3; ++c) {
    const auto phase = static_cast<uint32_t>(for_turbulence + 2 * c);
    const double turns = p.turbulence_hz * life.age;
    offset[c] = 0.7 * elementary::sin(glm::two_pi<double>() * (turns + life.random(phase))) +
                0.3 * elementary::sin(glm::two_pi<double>() * (2.3 * turns + life.random(phase + 1)));
  }
  return offset * (p.turbulence * life.share());
}

float cell_of(const Particles& p, const Life& life) {
  const double cells = static_cast<double>(p.desc.columns) * p.desc.rows;
  const double start = p.random_frame ? std::floor(life.random(for_frame) * cells) : 0.0;
  const double passed =
      p.frames_per_second > 0 ? life.age * p.frames_per_second : std::min(std::floor(life.share() * cells), cells - 1);
  return static_cast<float>(std::fmod(start + std::floor(passed), cells));
}

// Holds the placement and the size of the node.
struct Place {
  glm::dmat3 linear;
  glm::dvec3 origin;
  double scale;
  explicit Place(const double m[12])
      : linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]),
        origin(m[9], m[10], m[11]),
        scale(elementary::cbrt(std::abs(glm::determinant(linear)))) {}
};

sideray_sprite sprite_of(const Particles& p, const Life& life, const Place& place) {
  const Motion start = birth(p, life);
  const Carried by = carried(life.age, p.drag);
  const glm::dvec3 at = place.origin + place.linear * (start.place + start.velocity * by.by_velocity) +
                        p.acceleration * by.by_acceleration + turbulence(p, life);
  sideray_sprite s{};
  for (int c = 0; c < 3; ++c) s.position[c] = at[c];
  const double size = place.scale * over_life(p.size, life.share()) * (1 - p.size_variation * life.random(for_size));
  s.width = static_cast<float>(size);
  s.height = static_cast<float>(size * p.aspect);
  s.rotation = static_cast<float>(
      glm::radians(life.random(for_rotation, p.rotation_deg) + life.age * life.random(for_spin, p.spin_deg)));
  const glm::dvec3 color = over_life(p.color, life.share());
  for (int c = 0; c < 3; ++c) s.color[c] = static_cast<float>(color[c]);
  s.color[3] = static_cast<float>(over_life(p.alpha, life.share()));
  s.cell = cell_of(p, life);
  return s;
}

// Returns whether a scene can hold the sprite, which may have shrunk to nothing, or grown or moved too far.
bool can_be_shown(const sideray_sprite& s) {
  constexpr float largest_side = 1e9f;
  const bool is_near = std::all_of(std::begin(s.position), std::end(s.position),
                                   [](double x) { return std::abs(x) <= limits::coordinate; });
  return is_near && std::isfinite(s.rotation) && s.width > 0.0f && s.height > 0.0f && s.width <= largest_side &&
         s.height <= largest_side;
}

}  // namespace

std::vector<sideray_sprite> sprites_at(const Particles& p, const double world_from_node[12], double time_s) {
  const Place place(world_from_node);
  const double period = p.lifetime.high;
  std::vector<sideray_sprite> sprites;
  for (uint32_t slot = 0; slot < p.count; ++slot) {
    // Births are spread evenly over the period, each at a random time within its share.
    const double phase = (slot + static_cast<double>(hash01(slot, for_birth, p.seed))) / p.count;
    const double generation = std::floor(time_s / period - phase);
    if (!p.loop && generation != 0) continue;
    if (!p.prewarm && generation < 0) continue;
    Life life{p.seed, slot, static_cast<uint32_t>(static_cast<int64_t>(std::clamp(generation, -1e15, 1e15))), 0, 0};
    life.age = std::max(time_s - (generation + phase) * period, 0.0);
    life.length = life.random(for_lifetime, p.lifetime);
    if (life.age >= life.length) continue;
    sprites.push_back(sprite_of(p, life, place));
    if (!can_be_shown(sprites.back())) sprites.pop_back();
  }
  return sprites;
}

void simulate(Content& content, double time_s) {
  for (Emitter& e : content.emitters) e.sprites = sprites_at(e.particles, e.world_from_node, time_s);
}

void set_sprites(Scene& scene, const Content& content) {
  for (size_t i = 0; i < content.emitters.size(); ++i)
    scene.set_sprites(static_cast<sideray_particles>(i + 1), content.emitters[i].sprites);
}

}  // namespace sideray::scenes
