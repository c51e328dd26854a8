#include "terrace.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/builtin/bistro/bistro.h"
#include "scenes/builtin/bistro/textures.h"
#include "scenes/builtin/forest.h"

namespace sideray::retrofit {
namespace {

using glm::vec2;
using glm::vec3;
using scenes::ContentBuilder;
using scenes::Shape;
using scenes::Texel;
using scenes::bistro::Kit;
using scenes::bistro::left_x;
using scenes::bistro::right_x;
using scenes::bistro::window_z;

// The terrace is in front of the windows, between the wall and the kerb.
constexpr float wall_z = window_z - 0.14f, kerb_z = -6.25f, wing = 11.0f, roof_y = 8.2f;

uint32_t painted(Kit& kit, const std::string& name, uint32_t width, uint32_t height, const scenes::Paint& paint,
                 bool unlit = false) {
  sideray_material_desc d = scenes::opaque_material(vec3(1), 1.0f);
  d.base_color_texture.texture = paint_image(kit.b, name, width, height, paint);
  d.unlit = unlit;
  return kit.b.material(name, d);
}

Texel sky_texel(vec2 uv) {
  const float up = 1.0f - 2.0f * uv.y;  // 1 at the zenith, 0 at the horizon
  const vec3 zenith(0.24f, 0.45f, 0.78f), horizon(0.80f, 0.88f, 0.94f);
  const float cover = scenes::fractal_noise(uv * vec2(1, 2), 6, 6, 91);
  const float cloud = glm::smoothstep(0.50f, 0.68f, cover) * glm::smoothstep(0.02f, 0.3f, up);
  Texel t;
  t.color = glm::mix(horizon, zenith, glm::smoothstep(0.0f, 0.75f, up));
  t.color = glm::mix(t.color, vec3(0.98f, 0.97f, 0.95f) - 0.12f * cover, 0.9f * cloud);
  return t;
}

Texel flagstone_texel(vec2 uv) {
  const float row = std::floor(uv.y * 4.0f), shift = 0.37f * row;
  const vec2 stone = glm::fract(vec2(uv.x * 3.0f + shift, uv.y * 4.0f));
  const auto key = static_cast<uint32_t>(7.0f * row + std::floor(uv.x * 3.0f + shift));
  const vec2 inward = 0.5f - glm::abs(stone - 0.5f);
  const float top = glm::smoothstep(0.006f, 0.03f, std::min(inward.x, inward.y));
  const float grain = scenes::fractal_noise(uv, 16, 5, 93), own = scenes::hash01(key, 94);
  Texel t;
  t.color = glm::mix(vec3(0.34f, 0.31f, 0.27f), vec3(0.74f, 0.69f, 0.61f) * (0.80f + 0.2f * own), top) *
            (0.74f + 0.5f * grain);
  return t;
}

void add_sky(Kit& kit) {
  constexpr float radius = 70.0f;
  const Shape dome = Shape().sheet(48, 24, [](float u, float v) {
    const float azimuth = -glm::two_pi<float>() * u, elevation = glm::pi<float>() * (0.985f * v - 0.4925f);
    return radius *
           vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth));
  });
  kit.b.object("sky", kit.b.mesh(dome, "sky"), painted(kit, "day sky", 512, 512, sky_texel, true));
}

Texel lawn_texel(vec2 uv) {
  const float large = scenes::fractal_noise(uv, 4, 5, 97), fine = scenes::fractal_noise(uv, 64, 3, 98);
  Texel t;
  t.color = glm::mix(vec3(0.30f, 0.40f, 0.16f), vec3(0.46f, 0.56f, 0.22f), large) * (0.65f + 0.6f * fine);
  return t;
}

void add_paving(Kit& kit) {
  const Shape flags = Shape().quad({-wing, 0, kerb_z}, {-wing, 0, wall_z}, {wing, 0, wall_z}, {wing, 0, kerb_z},
                                   {(wall_z - kerb_z) / 1.8f, 2 * wing / 1.8f});
  kit.b.object("terrace", kit.b.mesh(flags, "terrace"), painted(kit, "flagstones", 512, 512, flagstone_texel));
  const Shape lawn =
      Shape().quad({-40, 0.04f, -13.6f}, {-4.2f, 0.04f, -13.6f}, {-4.2f, 0.04f, -34}, {-40, 0.04f, -34}, {12, 7});
  kit.b.object("lawn", kit.b.mesh(lawn, "lawn"), painted(kit, "grass", 512, 512, lawn_texel));
}

// Adds the street side of the house: plinth and fascia around the windows, plain walls beside and above.
void add_front(Kit& kit) {
  Shape joinery, stone, trim, dark;
  joinery.bevelled_box({left_x - 0.1f, 0, wall_z - 0.02f}, {right_x + 0.1f, 0.5f, window_z - 0.02f}, 0.01f);
  const int panels = 10;
  const float step = (right_x - left_x) / panels;
  for (int i = 0; i < panels; ++i) {
    const float x = left_x + step * static_cast<float>(i);
    joinery.bevelled_box({x + 0.08f, 0.10f, wall_z - 0.05f}, {x + step - 0.08f, 0.42f, wall_z}, 0.02f);
  }
  joinery.bevelled_box({left_x - 0.3f, 2.86f, wall_z - 0.10f}, {right_x + 0.3f, 3.42f, window_z}, 0.03f);
  joinery.bevelled_box({left_x - 0.4f, 3.40f, wall_z - 0.26f}, {right_x + 0.4f, 3.52f, window_z}, 0.03f);
  for (const float x : {left_x - 0.15f, right_x + 0.15f})
    joinery.bevelled_box({x - 0.15f, 0, wall_z - 0.08f}, {x + 0.15f, 2.9f, window_z}, 0.03f);
  const auto face = [&](float from, float to, float low, float high) {
    stone.quad({to, low, wall_z}, {from, low, wall_z}, {from, high, wall_z}, {to, high, wall_z},
               vec2(to - from, high - low) / 4.0f);
  };
  face(-wing, left_x - 0.25f, 0, roof_y);
  face(right_x + 0.25f, wing, 0, roof_y);
  face(left_x - 0.25f, right_x + 0.25f, 3.4f, roof_y);
  trim.bevelled_box({-wing, roof_y - 0.3f, wall_z - 0.35f}, {wing, roof_y, wall_z + 8.0f}, 0.06f, 0.3f);
  for (int i = 0; i < 6; ++i) {
    const float x = -8.2f + 3.3f * static_cast<float>(i), y = 4.1f;
    dark.quad({x + 0.5f, y, wall_z - 0.01f}, {x - 0.5f, y, wall_z - 0.01f}, {x - 0.5f, y + 1.8f, wall_z - 0.01f},
              {x + 0.5f, y + 1.8f, wall_z - 0.01f});
    trim.bevelled_box({x - 0.62f, y - 0.12f, wall_z - 0.16f}, {x + 0.62f, y, wall_z}, 0.02f, 0.3f);
    trim.bevelled_box({x - 0.62f, y + 1.8f, wall_z - 0.10f}, {x + 0.62f, y + 1.95f, wall_z}, 0.02f, 0.3f);
  }
  const auto add = [&](const char* name, const Shape& shape, uint32_t material) {
    kit.b.object(name, kit.b.mesh(shape, name), material);
  };
  add("shop front", joinery, kit.m.shopfront);
  add("front wall", stone, kit.m.facades[1]);
  add("front trim", trim, kit.m.facades[0]);
  add("upper windows", dark, kit.m.dark_window);
  constexpr float z = wall_z - 0.115f, half = 1.02f, y = 2.93f;
  const Shape sign = Shape().quad({half + 0.35f, y, z}, {0.35f - half, y, z}, {0.35f - half, y + 0.42f, z},
                                  {half + 0.35f, y + 0.42f, z});
  add("shop sign", sign, kit.m.gilt);
}

void add_greenery(Kit& kit) {
  const std::vector<scenes::forest::Species> species =
      scenes::forest::make_species(kit.b, scenes::forest::paint_textures(kit.b), 3);
  const auto plant = [&](size_t kind, vec3 at, float turn, float size) {
    glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(at));
    m = glm::scale(glm::rotate(m, double{turn}, glm::dvec3(0, 1, 0)), glm::dvec3(double{size}));
    for (const scenes::forest::Part& part : species[kind].parts)
      kit.b.object(fmt::format("{} {:.1f}", part.name, at.x), part.mesh, part.material, m);
  };
  constexpr size_t oak = 0, beech = 1, birch = 2, bush = 4, fern = 5;
  plant(birch, {-2.6f, -0.05f, -6.9f}, 0.4f, 0.86f);
  plant(oak, {-7.6f, -0.05f, -6.9f}, 1.9f, 0.8f);
  plant(beech, {-5.8f, 0, -15.6f}, 2.7f, 0.8f);
  plant(oak, {-10.4f, 0, -18.0f}, 0.7f, 0.9f);
  plant(birch, {-8.0f, 0, -22.0f}, 0.1f, 0.8f);
  plant(bush, {-8.4f, 0, -14.4f}, 0.3f, 1.3f);
  plant(bush, {-11.6f, 0, -15.0f}, 2.3f, 1.5f);
  plant(bush, {-6.6f, 0, -19.0f}, 4.3f, 1.4f);
  plant(birch, {6.0f, -0.05f, -6.7f}, 0.2f, 0.9f);
  Shape box;
  box.bevelled_box({-0.55f, 0, -0.2f}, {0.55f, 0.42f, 0.2f}, 0.02f);
  const uint32_t trough = kit.b.mesh(box, "trough");
  for (const vec2 at : {vec2(-4.55f, -5.0f), vec2(5.15f, -5.0f), vec2(-3.3f, -6.0f)}) {
    kit.b.object(fmt::format("trough {:.1f}", at.x), trough, kit.m.shopfront, glm::dvec3(at.x, 0, at.y));
    plant(bush, {at.x - 0.22f, 0.36f, at.y}, at.x, 0.62f);
    plant(fern, {at.x + 0.3f, 0.38f, at.y}, 2.0f * at.x, 0.7f);
  }
}

void add_tables(Kit& kit) {
  constexpr scenes::bistro::TablePlace places[] = {{{1.25f, -6.05f}, 205.0f, 2},
                                                   {{-0.95f, -5.15f}, 40.0f, 3},
                                                   {{3.1f, -5.0f}, 75.0f, 3},
                                                   {{-3.0f, -4.95f}, 10.0f, 2}};
  for (int i = 0; i < 4; ++i) add_table(kit, i + 1, places[i], 2);
}

// Adds a van that drives along +x, with its origin at its middle on the ground.
void add_van(Kit& kit) {
  Shape body, glass, tyres, hubs;
  body.bevelled_box({-2.1f, 0.35f, -0.9f}, {2.1f, 1.15f, 0.9f}, 0.12f);
  body.bevelled_box({-2.1f, 1.05f, -0.86f}, {1.2f, 2.15f, 0.86f}, 0.16f);
  for (const float z : {-0.875f, 0.875f}) {
    const float s = z > 0 ? 1.0f : -1.0f;
    const auto pane = [&](float x0, float x1) {
      glass.quad({s > 0 ? x0 : x1, 1.3f, z}, {s > 0 ? x1 : x0, 1.3f, z}, {s > 0 ? x1 : x0, 1.9f, z},
                 {s > 0 ? x0 : x1, 1.9f, z});
    };
    pane(0.1f, 0.95f);
    pane(-0.9f, -0.05f);
    for (const float x : {-1.3f, 1.35f}) {
      const glm::mat4 turned = glm::rotate(glm::translate(glm::mat4(1), vec3(x, 0.36f, s * 0.72f)),
                                           s * glm::half_pi<float>(), vec3(1, 0, 0));
      tyres.append(Shape().cylinder({0, 0, 0}, 0.36f, 0.24f, 24), turned);
      hubs.append(Shape().cylinder({0, 0.22f, 0}, 0.2f, 0.04f, 16), turned);
    }
  }
  const uint32_t paint = kit.b.material("van paint", scenes::opaque_material({0.62f, 0.05f, 0.03f}, 0.3f));
  const glm::dvec3 at(-4.6, -0.12, -10.4);
  kit.b.object("van body", kit.b.mesh(body, "van body"), paint, at);
  kit.b.object("van windows", kit.b.mesh(glass, "van windows"), kit.m.dark_window, at);
  kit.b.object("van tyres", kit.b.mesh(tyres, "van tyres"), kit.m.iron, at);
  kit.b.object("van hubs", kit.b.mesh(hubs, "van hubs"), kit.m.steel, at);
}

// Adds a lantern that hangs from the fascia by a chain, with its origin at the hook.
void add_lantern(Kit& kit) {
  Shape iron, glass;
  constexpr float top = -0.42f, bottom = -0.80f, wide = 0.13f, narrow = 0.09f;
  iron.tube({{0, 0, 0}, {0, top, 0}}, 0.008f, 8, 1);
  iron.lathe({0, top, 0}, {{0.19f, 0}, {0.10f, 0.09f}, {0.02f, 0.13f}, {0, 0.13f}}, 4);
  iron.lathe({0, bottom, 0}, {{0, -0.04f}, {0.12f, -0.03f}, {0.13f, 0}, {0, 0.01f}}, 4);
  const auto corner = [&](int i, float y, float r) {
    const float a = glm::half_pi<float>() * static_cast<float>(i);
    return vec3(r * std::cos(a), y, r * std::sin(a)) * vec3(1.35f, 1, 1.35f);
  };
  for (int i = 0; i < 4; ++i) {
    iron.tube({corner(i, bottom, narrow), corner(i, top, wide)}, 0.009f, 6, 1);
    glass.quad(corner(i + 1, bottom, narrow), corner(i, bottom, narrow), corner(i, top, wide),
               corner(i + 1, top, wide));
  }
  const glm::dvec3 at(-2.2, 2.95, double{wall_z} - 0.75);
  Shape arm;
  arm.tube({{0, 0, 0.8f}, {0, 0.05f, 0.4f}, {0, 0.06f, 0.1f}, {0, 0, 0}}, 0.014f, 8, 4);
  kit.b.object("arm", kit.b.mesh(arm, "arm"), kit.m.iron, at);
  kit.b.object("lantern iron", kit.b.mesh(iron, "lantern iron"), kit.m.iron, at);
  kit.b.object("lantern glass", kit.b.mesh(glass, "lantern glass"), kit.m.vitrine, at);
  const Shape candle = Shape().cylinder({0, bottom, 0}, 0.035f, 0.16f, 16);
  kit.b.object("lantern candle", kit.b.mesh(candle, "lantern candle"), kit.m.wax, at);
}

}  // namespace

scenes::Content make_terrace() {
  Kit kit(0);
  kit.m = scenes::bistro::make_materials(kit.b);
  kit.coarseness = 2;
  add_room(kit);
  add_windows(kit);
  add_bar(kit);
  add_lamps(kit);
  add_street(kit);
  add_sky(kit);
  add_paving(kit);
  add_front(kit);
  add_greenery(kit);
  add_tables(kit);
  add_van(kit);
  add_lantern(kit);
  scenes::Content content = kit.b.take();
  content.lights.clear();
  // A park replaces two houses across the street, and day replaces the evening.
  std::erase_if(content.objects, [](const scenes::Object& o) {
    return o.name == "dusk" || o.name.starts_with("house1 ") || o.name.starts_with("house2 ");
  });
  return content;
}

}  // namespace sideray::retrofit
