#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/builtin_scenes.h"
#include "scenes/shapes.h"

namespace sideray::scenes {
namespace {

// The room: x -4..4, y 0..3, z -4 (windows to the street)..5.
constexpr float room_x = 4.0f, room_height = 3.0f, window_z = -4.0f, back_z = 5.0f;
constexpr float table_height = 0.76f;

using Profile = std::vector<glm::vec2>;

// Glassware as solids of revolution with an inside: outer wall up, rim, inner wall down.
const Profile wine_glass = {{0, 0},           {0.035f, 0},      {0.034f, 0.004f}, {0.008f, 0.010f}, {0.005f, 0.022f},
                            {0.005f, 0.095f}, {0.012f, 0.105f}, {0.032f, 0.125f}, {0.041f, 0.150f}, {0.040f, 0.180f},
                            {0.034f, 0.215f}, {0.032f, 0.215f}, {0.037f, 0.180f}, {0.038f, 0.150f}, {0.029f, 0.127f},
                            {0.008f, 0.110f}, {0, 0.108f}};
const Profile wine = {{0, 0.110f}, {0.026f, 0.127f}, {0.0355f, 0.150f}, {0.036f, 0.158f}, {0, 0.158f}};
const Profile tumbler = {{0, 0}, {0.031f, 0}, {0.036f, 0.09f}, {0.034f, 0.09f}, {0.0295f, 0.010f}, {0, 0.010f}};
const Profile bottle = {{0, 0},           {0.036f, 0},       {0.038f, 0.006f}, {0.038f, 0.185f}, {0.034f, 0.210f},
                        {0.016f, 0.240f}, {0.0135f, 0.300f}, {0.015f, 0.303f}, {0.015f, 0.315f}, {0.011f, 0.315f},
                        {0.011f, 0.240f}, {0.031f, 0.205f},  {0.035f, 0.183f}, {0.035f, 0.010f}, {0, 0.008f}};
const Profile lamp_shade = {{0.03f, 0.30f},  {0.05f, 0.28f},   {0.10f, 0.18f},   {0.16f, 0.02f},
                            {0.155f, 0.02f}, {0.095f, 0.175f}, {0.045f, 0.275f}, {0.025f, 0.295f}};

class Bistro {
 public:
  Content make() {
    materials();
    room();
    street();
    windows();
    bar();
    const std::array<glm::dvec3, 5> tables = {
        {{-2.4, 0, -2.5}, {-0.3, 0, -1.7}, {2.1, 0, -2.6}, {-1.7, 0, 0.5}, {1.7, 0, 0.1}}};
    for (size_t i = 0; i < tables.size(); ++i) table(static_cast<int>(i), tables[i]);
    lights();
    const double eye[3] = {0.42, 1.2, -0.52}, target[3] = {-0.42, 0.8, -1.9};
    b_.camera("table", look_at(eye, target, 52.0f));
    const double overview_eye[3] = {3.3, 2.1, 4.2}, overview_target[3] = {-0.6, 0.8, -1.6};
    b_.camera("overview", look_at(overview_eye, overview_target, 55.0f));
    return b_.take();
  }

 private:
  uint32_t textured(const char* name, uint32_t texture, float roughness) {
    sideray_material_desc d = opaque_material(glm::vec3(1), roughness);
    d.base_color_texture.texture = texture;
    return b_.material(name, d);
  }

  void materials() {
    floor_ = textured("floor tiles", b_.checker("floor tiles", {150, 120, 92}, {64, 48, 40}, 8), 0.35f);
    plaster_ = b_.material("plaster", opaque_material({0.62f, 0.5f, 0.36f}, 0.9f));
    wood_ = b_.material("wood", opaque_material({0.22f, 0.1f, 0.05f}, 0.45f));
    top_ = b_.material("table top", opaque_material({0.42f, 0.22f, 0.11f}, 0.3f));
    sideray_material_desc brass = opaque_material({0.9f, 0.66f, 0.32f}, 0.3f);
    brass.metallic = 1.0f;
    brass_ = b_.material("brass", brass);
    clear_ = b_.material("clear glass", glass_material({0.97f, 0.98f, 0.98f}, 0.03f));
    tints_[0] = b_.material("green glass", glass_material({0.35f, 0.7f, 0.38f}, 0.05f));
    tints_[1] = b_.material("amber glass", glass_material({0.85f, 0.5f, 0.16f}, 0.05f));
    tints_[2] = b_.material("blue glass", glass_material({0.4f, 0.6f, 0.88f}, 0.05f));
    wine_ = b_.material("red wine", glass_material({0.45f, 0.04f, 0.06f}, 0.04f));
    sideray_material_desc window = opaque_material({0.85f, 0.95f, 1.0f}, 0.04f);
    window.base_color[3] = 0.12f;
    window.alpha_mode = SIDERAY_BLEND;
    window.blend_mode = SIDERAY_BLEND_PREMULTIPLIED;
    window.double_sided = 1;
    for (int i = 0; i < 3; ++i) window.base_color[i] *= 0.1f;  // premultiplied: what the pane itself adds
    window_ = b_.material("window glass", window, RayTraced::yes);
    sideray_material_desc bulb = opaque_material({1.0f, 0.85f, 0.6f}, 0.6f);
    for (int i = 0; i < 3; ++i) bulb.emissive[i] = std::array{9.0f, 6.2f, 3.2f}[static_cast<size_t>(i)];
    bulb_ = b_.material("bulb", bulb);
    wine_glass_ = b_.mesh(Shape().lathe({}, wine_glass, 40), "wine glass");
    wine_fill_ = b_.mesh(Shape().lathe({}, wine, 40), "wine");
    tumbler_ = b_.mesh(Shape().lathe({}, tumbler, 40), "tumbler");
    bottle_ = b_.mesh(Shape().lathe({}, bottle, 40), "bottle");
    plate_ = b_.mesh(
        Shape().lathe({}, {{0, 0}, {0.06f, 0}, {0.11f, 0.014f}, {0.108f, 0.017f}, {0.06f, 0.005f}, {0, 0.005f}}, 48),
        "plate");
    china_ = b_.material("china", opaque_material({0.8f, 0.78f, 0.72f}, 0.2f));
  }

  void room() {
    const float x = room_x, h = room_height;
    b_.object(
        "floor",
        b_.mesh(Shape().quad({-x, 0, back_z}, {x, 0, back_z}, {x, 0, window_z}, {-x, 0, window_z}, {3, 3}), "floor"),
        floor_);
    Shape walls;
    walls.quad({-x, 0, back_z}, {-x, 0, window_z}, {-x, h, window_z}, {-x, h, back_z});
    walls.quad({x, 0, window_z}, {x, 0, back_z}, {x, h, back_z}, {x, h, window_z});
    walls.quad({x, 0, back_z}, {-x, 0, back_z}, {-x, h, back_z}, {x, h, back_z});
    walls.quad({-x, h, window_z}, {x, h, window_z}, {x, h, back_z}, {-x, h, back_z});
    b_.object("walls", b_.mesh(walls, "walls"), plaster_);
    Shape panels;
    panels.box({-x, 0, window_z}, {-x + 0.05f, 1.0f, back_z}).box({x - 0.05f, 0, window_z}, {x, 1.0f, back_z});
    panels.box({-x, 0, window_z - 0.08f}, {x, 0.55f, window_z + 0.02f});
    panels.box({-x, 2.6f, window_z - 0.08f}, {x, h, window_z + 0.02f});
    for (float post = -x; post <= x + 0.01f; post += 2.0f)
      panels.box({post - 0.06f, 0.55f, window_z - 0.06f}, {post + 0.06f, 2.6f, window_z + 0.02f});
    b_.object("panelling", b_.mesh(panels, "panelling"), wood_);
  }

  void street() {
    const uint32_t asphalt = b_.material("asphalt", opaque_material({0.07f, 0.075f, 0.085f}, 0.6f));
    b_.object(
        "street",
        b_.mesh(Shape().quad({-40, -0.05f, window_z}, {40, -0.05f, window_z}, {40, -0.05f, -16}, {-40, -0.05f, -16}),
                "street"),
        asphalt);
    const uint32_t facade = b_.material("facade", opaque_material({0.2f, 0.14f, 0.12f}, 0.9f));
    b_.object("facade", b_.mesh(Shape().box({-40, 0, -16.4f}, {40, 9, -16}), "facade"), facade);
    sideray_material_desc lit = opaque_material({0.3f, 0.2f, 0.1f}, 0.8f);
    for (int i = 0; i < 3; ++i) lit.emissive[i] = std::array{1.8f, 1.1f, 0.45f}[static_cast<size_t>(i)];
    const uint32_t lit_window = b_.material("lit window", lit);
    Shape windows;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 19; ++column)
        if ((row * 5 + column * 3) % 4 != 0) {
          const float wx = -27.0f + 3.0f * static_cast<float>(column), wy = 0.8f + 2.7f * static_cast<float>(row);
          windows.quad({wx, wy, -15.98f}, {wx + 1.2f, wy, -15.98f}, {wx + 1.2f, wy + 1.6f, -15.98f},
                       {wx, wy + 1.6f, -15.98f});
        }
    b_.object("lit windows", b_.mesh(windows, "lit windows"), lit_window);
  }

  void windows() {
    for (int i = 0; i < 4; ++i) {
      const float x = -4.0f + 2.0f * static_cast<float>(i);
      b_.object(fmt::format("window{}", i),
                b_.mesh(Shape().quad({x + 0.06f, 0.55f, window_z - 0.02f}, {x + 1.94f, 0.55f, window_z - 0.02f},
                                     {x + 1.94f, 2.6f, window_z - 0.02f}, {x + 0.06f, 2.6f, window_z - 0.02f}),
                        fmt::format("window{}", i)),
                window_);
    }
  }

  void bar() {
    Shape counter;
    counter.box({2.9f, 0, 0.9f}, {3.4f, 1.05f, 4.6f}).box({2.8f, 1.05f, 0.8f}, {3.5f, 1.1f, 4.7f});
    for (int shelf = 0; shelf < 3; ++shelf) {
      const float y = 1.25f + 0.45f * static_cast<float>(shelf);
      counter.box({3.72f, y - 0.03f, 0.9f}, {3.95f, y, 4.6f});
    }
    b_.object("bar", b_.mesh(counter, "bar"), wood_);
    for (int shelf = 0; shelf < 3; ++shelf)
      for (int i = 0; i < 14; ++i)
        b_.object(fmt::format("bottle.bar{}.{}", shelf, i), bottle_, tints_[(i * 7 + shelf * 2) % 3],
                  {3.84, 1.25 + 0.45 * shelf, 1.05 + 0.25 * i}, 40.0 * i);
    for (int i = 0; i < 8; ++i)
      b_.object(fmt::format("tumbler.bar{}", i), tumbler_, clear_, {3.0 + 0.1 * (i % 2), 1.1, 1.1 + 0.11 * i});
  }

  void table(int index, glm::dvec3 at) {
    if (table_mesh_ == 0) {
      table_mesh_ = b_.mesh(Shape().cylinder({0, table_height - 0.03f, 0}, 0.48f, 0.03f, 64), "table top");
      leg_mesh_ = b_.mesh(
          Shape().cylinder({0, 0.03f, 0}, 0.035f, table_height - 0.06f, 24).cylinder({0, 0, 0}, 0.26f, 0.03f, 40),
          "table leg");
      Shape chair;
      chair.box({-0.2f, 0.43f, -0.2f}, {0.2f, 0.47f, 0.2f}).box({-0.2f, 0.47f, 0.17f}, {0.2f, 0.92f, 0.2f});
      for (const float x : {-0.2f, 0.165f})
        for (const float z : {-0.2f, 0.165f}) chair.box({x, 0, z}, {x + 0.035f, 0.43f, z + 0.035f});
      chair_mesh_ = b_.mesh(chair, "chair");
    }
    b_.object(fmt::format("table{}", index), table_mesh_, top_, at);
    b_.object(fmt::format("leg{}", index), leg_mesh_, brass_, at);
    for (int i = 0; i < 3; ++i) {
      const double a = 2.0944 * i + 0.9 * index;
      b_.object(fmt::format("chair{}.{}", index, i), chair_mesh_, wood_,
                at + glm::dvec3(0.75 * std::sin(a), 0, 0.75 * std::cos(a)), glm::degrees(a));
    }
    set_table(index, at + glm::dvec3(0, table_height, 0));
  }

  // Glasses crowd the table in a spiral, so that many overlap from any side.
  void set_table(int index, glm::dvec3 at) {
    for (int i = 0; i < 14; ++i) {
      const double a = 2.39996 * i + index, r = 0.1 + 0.024 * i;
      const glm::dvec3 spot = at + glm::dvec3(r * std::sin(a), 0, r * std::cos(a));
      const std::string suffix = fmt::format("{}.{}", index, i);
      if (i % 3 == 0) {
        b_.object("wineglass" + suffix, wine_glass_, clear_, spot);
        if (i % 2 == 0) b_.object("wine" + suffix, wine_fill_, wine_, spot);
      } else if (i % 3 == 1) {
        b_.object("tumbler" + suffix, tumbler_, i == 4 ? tints_[2] : clear_, spot);
      } else if (i == 8) {
        b_.object("plate" + suffix, plate_, china_, spot * glm::dvec3(1) + glm::dvec3(0, 0.001, 0));
      } else {
        b_.object("bottle" + suffix, bottle_, tints_[(i + index) % 3], spot);
      }
    }
  }

  void lights() {
    const uint32_t shade = b_.mesh(Shape().lathe({}, lamp_shade, 48), "lamp shade");
    const uint32_t bulb = b_.mesh(Shape().sphere({0, 0.12f, 0}, 0.035f, 24), "bulb");
    const uint32_t cord = b_.mesh(Shape().cylinder({0, 0.3f, 0}, 0.006f, 1.1f, 8), "cord");
    const std::array<glm::dvec3, 4> lamps = {
        {{-2.2, 1.75, -2.3}, {-0.3, 1.75, -1.6}, {1.9, 1.75, -2.3}, {0.1, 1.75, 0.6}}};
    for (size_t i = 0; i < lamps.size(); ++i) {
      b_.object(fmt::format("shade{}", i), shade, brass_, lamps[i]);
      b_.object(fmt::format("bulb{}", i), bulb, bulb_, lamps[i]);
      b_.object(fmt::format("cord{}", i), cord, wood_, lamps[i]);
      const glm::vec3 position = glm::vec3(lamps[i]) + glm::vec3(0, 0.04f, 0);
      b_.light(fmt::format("lamp{}", i), point_light(position, {2.6f, 1.75f, 0.95f}, 12.0f));
    }
    b_.light("dusk", sun_light({0.35f, -0.28f, 0.9f}, {0.55f, 0.42f, 0.38f}));
  }

  ContentBuilder b_{"bistro"};
  uint32_t floor_ = 0, plaster_ = 0, wood_ = 0, top_ = 0, brass_ = 0, clear_ = 0, wine_ = 0, window_ = 0, bulb_ = 0,
           china_ = 0;
  std::array<uint32_t, 3> tints_{};
  uint32_t wine_glass_ = 0, wine_fill_ = 0, tumbler_ = 0, bottle_ = 0, plate_ = 0;
  uint32_t table_mesh_ = 0, leg_mesh_ = 0, chair_mesh_ = 0;
};

}  // namespace

Content make_bistro(const Numbers&) {
  return Bistro().make();
}

}  // namespace sideray::scenes
