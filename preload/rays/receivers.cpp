#include "preload/rays/receivers.h"

#include <algorithm>
#include <cmath>

namespace sideray::run {
namespace {

const FixedLight* light_of(const Lighting* lighting, int number) {
  for (int i = 0; lighting && i < lighting->lights; ++i)
    if (lighting->number[i] == number) return &lighting->light[i];
  return nullptr;
}

// Allows for rounding, because each draw's matrices give the light's position anew.
bool is_same_place(const FixedLight& a, const FixedLight& b) {
  float size = 0, apart = 0;
  for (int i = 0; i < 4; ++i) size = std::max(size, std::abs(a.position[i])), apart = std::max(apart, std::abs(a.position[i] - b.position[i]));
  return apart <= 1e-3f * size;
}

}  // namespace

void Receivers::begin_frame() {
  clear();
  sun_.reset();
  farthest_origin_ = 0;
  names_.begin_frame();
}

Receiver Receivers::lit(const DrawState& state, int sun, Taken& taken) {
  Receiver draw;
  taken = Taken::nothing;
  const FixedLight* light = state.lighting && !state.shows_texture_alone() ? light_of(state.lights.get(), sun) : nullptr;
  if (!light) return draw;
  if (!sun_) sun_ = *light;
  taken = is_same_place(*light, *sun_) ? Taken::receives : Taken::other_sun;
  if (taken == Taken::receives) draw.lights = state.lights;
  return draw;
}

void Receivers::keep(std::vector<Receiver>& list, Receiver draw, const DrawState& state,
                     std::shared_ptr<const Geometry> geometry, uint64_t texture) {
  draw.modelview = state.modelview;
  farthest_origin_ = std::max(farthest_origin_, std::hypot(state.modelview[12], state.modelview[13], state.modelview[14]));
  draw.material = state.material;
  draw.fog = state.fog;
  draw.colored = state.color_material;
  draw.name = names_.name(hash_of(*geometry, {false, false, 0}), texture);
  draw.geometry = std::move(geometry);
  list.push_back(std::move(draw));
}

Receivers::Taken Receivers::add(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture,
                                const Rule& rule, int sun) {
  if (!may_receive(state) || !geometry->is_surface()) return Taken::nothing;
  Taken taken;
  Receiver draw = lit(state, sun, taken);
  if (rule.kind == Kind::opaque && rule.shade >= 0)
    draw.lights.reset(), draw.shade = rule.shade, taken = Taken::receives;
  if (taken == Taken::receives) keep(draws_, std::move(draw), state, std::move(geometry), texture);
  return taken;
}

Receivers::Taken Receivers::hold(const DrawState& state, std::shared_ptr<const Geometry> geometry, uint64_t texture,
                                 int sun) {
  if (!has_place(state) || !geometry->is_surface()) return Taken::nothing;
  Taken taken;
  Receiver draw = lit(state, sun, taken);
  if (taken == Taken::receives) keep(held_, std::move(draw), state, std::move(geometry), texture);
  return taken;
}

}  // namespace sideray::run
