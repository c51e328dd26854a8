#include <algorithm>
#include <limits>

#include "scenes/builtin/bistro/bistro.h"
#include "scenes/builtin/bistro/textures.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec3;
using Desc = sideray_material_desc;

void set(float* to, vec3 value) {
  for (int i = 0; i < 3; ++i) to[i] = value[i];
}

class Palette {
 public:
  explicit Palette(ContentBuilder& b) : b_(b) {
    Texture none;
    none.name = "shade";
    none.width = none.height = 4;
    none.rgba.assign(64, 0);
    for (size_t i = 3; i < 64; i += 4) none.rgba[i] = 255;
    shade_ = b.texture(std::move(none));
  }

  Materials make() {
    textured();
    plain();
    lights();
    glass();
    liquids();
    panes();
    street();
    return m_;
  }

 private:
  // Returns an untextured material that gets the share `ambient` of the environment's light.
  Desc dim(vec3 color, float roughness, float ambient = room_ambient) const {
    Desc d = opaque_material(color, roughness);
    d.occlusion_texture.texture = shade_;
    d.occlusion_strength = 1.0f - ambient;
    return d;
  }

  static Desc mapped(const Maps& maps, vec3 tint = vec3(1), float roughness = 1.0f) {
    Desc d = opaque_material(tint, roughness);
    d.base_color_texture.texture = maps.color;
    d.metallic_roughness_texture.texture = d.occlusion_texture.texture = maps.surface;
    d.normal_texture.texture = maps.normal;
    return d;
  }

  static Desc lacquered(Desc d, float roughness, float coat = 1.0f) {
    d.clearcoat = coat;
    d.clearcoat_roughness = roughness;
    return d;
  }

  uint32_t image(const char* name, uint32_t texture, float roughness) {
    Desc d = dim(vec3(1), roughness);
    d.base_color_texture.texture = texture;
    return b_.material(name, d);
  }

  void textured() {
    m_.floor = b_.material("floor tiles", mapped(paint_floor(b_)));
    m_.plaster = b_.material("plaster", mapped(paint_plaster(b_)));
    const Maps wood = paint_wood(b_);
    m_.walnut = b_.material("walnut", mapped(wood, {0.85f, 0.66f, 0.55f}));
    m_.table_top = b_.material("lacquered table top", lacquered(mapped(wood, {1.0f, 0.74f, 0.52f}), 0.12f, 0.6f));
    m_.bar_top = b_.material("lacquered bar top", lacquered(mapped(wood, {0.9f, 0.5f, 0.38f}), 0.06f));
    const Maps weave = paint_weave(b_);
    Desc velvet = mapped(weave, {0.42f, 0.035f, 0.045f});
    velvet.normal_scale = 0.4f;
    velvet.double_sided = 1;
    set(velvet.sheen_color, {0.75f, 0.16f, 0.16f});
    velvet.sheen_roughness = 0.35f;
    m_.velvet = b_.material("velvet", velvet);
    Desc linen = mapped(weave, {0.80f, 0.66f, 0.46f});
    linen.double_sided = 1;
    linen.diffuse_transmission = 0.5f;
    set(linen.diffuse_transmission_color, {1.0f, 0.72f, 0.42f});
    set(linen.emissive, vec3(0.95f, 0.60f, 0.28f) * 1.1f);
    linen.emissive_texture.texture = weave.color;
    m_.linen = b_.material("lamp linen", linen);
    m_.leather = b_.material("leather", mapped(paint_leather(b_)));
    m_.cane = b_.material("cane", mapped(paint_cane(b_)));
    Desc leaf = mapped(paint_leaf(b_), vec3(1));
    leaf.double_sided = 1;
    leaf.diffuse_transmission = 0.45f;
    set(leaf.diffuse_transmission_color, {0.30f, 0.48f, 0.10f});
    m_.leaf = b_.material("leaf", leaf);
    m_.chalkboard = image("chalkboard", paint_chalkboard(b_), 0.85f);
    for (int i = 0; i < 3; ++i)
      m_.paintings[static_cast<size_t>(i)] =
          image(("painting " + std::to_string(i)).c_str(), paint_painting(b_, i), 0.5f);
    for (int i = 0; i < 4; ++i)
      m_.labels[static_cast<size_t>(i)] = image(("label " + std::to_string(i)).c_str(), paint_label(b_, i), 0.6f);
    Desc gilt = dim({1.0f, 0.78f, 0.38f}, 0.35f, 0.35f);
    gilt.base_color_texture.texture = paint_sign(b_);
    gilt.alpha_mode = SIDERAY_MASK;
    gilt.metallic = 0.6f;
    gilt.double_sided = 1;
    m_.gilt = b_.material("gilt letters", gilt);
  }

  void plain() {
    struct Row {
      uint32_t Materials::*slot;
      const char* name;
      vec3 color;
      float roughness, metallic, ambient;
    };
    static const Row rows[] = {
        {&Materials::ceiling, "ceiling", {0.62f, 0.50f, 0.36f}, 0.9f, 0, 0.16f},
        {&Materials::brass, "brass", {0.92f, 0.66f, 0.30f}, 0.28f, 1, 0.22f},
        {&Materials::steel, "steel", {0.62f, 0.62f, 0.60f}, 0.22f, 1, 0.25f},
        {&Materials::iron, "cast iron", {0.022f, 0.024f, 0.026f}, 0.45f, 0, room_ambient},
        {&Materials::china, "china", {0.82f, 0.80f, 0.75f}, 0.16f, 0, room_ambient},
        {&Materials::stem, "stem", {0.10f, 0.16f, 0.05f}, 0.6f, 0, room_ambient},
        {&Materials::terracotta, "terracotta", {0.45f, 0.17f, 0.09f}, 0.85f, 0, room_ambient},
        {&Materials::soil, "soil", {0.03f, 0.02f, 0.015f}, 1.0f, 0, room_ambient},
        {&Materials::cork, "cork", {0.45f, 0.28f, 0.15f}, 0.9f, 0, room_ambient},
        {&Materials::foil, "foil", {0.42f, 0.05f, 0.06f}, 0.35f, 0.7f, 0.2f},
        {&Materials::frame, "gilded frame", {0.75f, 0.52f, 0.22f}, 0.4f, 0.8f, 0.2f},
        {&Materials::bread, "bread", {0.50f, 0.26f, 0.10f}, 0.8f, 0, room_ambient},
        {&Materials::lemon, "lemon", {0.82f, 0.58f, 0.06f}, 0.4f, 0, room_ambient},
        {&Materials::petal, "petal", {0.70f, 0.10f, 0.14f}, 0.5f, 0, room_ambient},
    };
    for (const Row& row : rows) {
      Desc d = dim(row.color, row.roughness, row.ambient);
      d.metallic = row.metallic;
      if (row.slot == &Materials::petal) d.double_sided = 1;
      m_.*row.slot = b_.material(row.name, d);
    }
    m_.panel = b_.material("painted panel", lacquered(dim({0.042f, 0.150f, 0.112f}, 0.5f), 0.3f));
    Desc paper = dim({0.86f, 0.78f, 0.62f}, 0.9f);
    paper.double_sided = 1;
    paper.diffuse_transmission = 0.6f;
    set(paper.diffuse_transmission_color, {1.0f, 0.80f, 0.52f});
    set(paper.emissive, vec3(1.0f, 0.66f, 0.34f) * 0.75f);
    m_.paper = b_.material("lamp paper", paper);
  }

  void lights() {
    const auto glowing = [&](vec3 radiance, float roughness) {
      Desc d = dim({0.8f, 0.7f, 0.55f}, roughness);
      set(d.emissive, radiance);
      return d;
    };
    // The lights are inside these objects: a translucent material lets some of their light out.
    const auto frosted = [&](const char* name, vec3 radiance) {
      Desc d = glowing(radiance, 0.55f);
      d.transmission = 0.4f;
      d.thickness = 0.001f;
      return b_.material(name, d);
    };
    m_.bulb = frosted("bulb", vec3(36.0f, 23.0f, 11.5f));
    m_.opal = frosted("opal glass globe", vec3(3.6f, 2.4f, 1.3f));
    m_.wax = b_.material("wax", glowing(vec3(0.26f, 0.13f, 0.045f), 0.5f));
    Desc flame = glowing(vec3(5.0f, 2.6f, 0.8f), 1.0f);
    flame.alpha_mode = SIDERAY_BLEND;
    flame.blend_mode = SIDERAY_BLEND_ADDITIVE;
    set(flame.base_color, vec3(0));
    m_.flame = b_.material("flame", flame, RayTraced::no);
  }

  // Returns solid glass in which white light becomes `tint` after `distance` metres; `wall` is the thickness that one
  // surface stands for. Only faces toward the eye are drawn: the outside of the near wall, the inside of the far one.
  static Desc solid(vec3 tint, float distance, float wall, float ior, float roughness) {
    Desc d = glass_material({0.965f, 0.98f, 0.975f}, roughness);
    d.double_sided = 0;
    d.ior = ior;
    d.thickness = wall;
    d.attenuation_distance = distance;
    set(d.attenuation_color, tint);
    return d;
  }

  void glass() {
    m_.clear = b_.material("clear glass", solid({0.90f, 0.96f, 0.94f}, 0.02f, 0.0018f, 1.56f, 0.05f));
    m_.crystal = b_.material("lead crystal", solid({0.96f, 0.97f, 0.96f}, 0.02f, 0.002f, 1.66f, 0.05f));
    m_.shade_glass = b_.material("lamp glass", solid({0.96f, 0.80f, 0.52f}, 0.004f, 0.0028f, 1.5f, 0.04f));
    static constexpr vec3 tints[] = {
        {0.16f, 0.42f, 0.10f}, {0.72f, 0.30f, 0.06f}, {0.12f, 0.24f, 0.72f}, {0.80f, 0.92f, 0.86f}};
    static constexpr const char* names[] = {"green bottle glass", "amber bottle glass", "cobalt bottle glass",
                                            "pale bottle glass"};
    for (size_t i = 0; i < 4; ++i)
      m_.bottle_glass[i] = b_.material(names[i], solid(tints[i], 0.004f, 0.003f, 1.52f, 0.03f));
  }

  void liquids() {
    static constexpr vec3 tints[] = {
        {0.34f, 0.012f, 0.03f}, {0.94f, 0.78f, 0.36f}, {0.80f, 0.33f, 0.05f}, {0.62f, 0.80f, 0.20f}};
    static constexpr const char* names[] = {"red wine", "white wine", "cognac", "absinthe"};
    // Most of a drink's surface touches glass, not air, and reflects a tenth as much as it would in air.
    const auto drink = [&](const char* name, vec3 tint, float distance, float ior) {
      Desc d = solid(tint, distance, 0.04f, ior, 0.02f);
      d.specular = 0.25f;
      return b_.material(name, d);
    };
    for (size_t i = 0; i < 4; ++i) m_.drinks[i] = drink(names[i], tints[i], 0.03f, 1.345f);
    m_.water = drink("water", {0.93f, 0.97f, 0.98f}, 0.1f, 1.333f);
  }

  // Returns an alpha-blended pane, as in older content. Alpha is premultiplied: `color` is the light that the pane
  // adds.
  Desc pane(vec3 color, float alpha) {
    Desc d = opaque_material(color * alpha, 0.04f);
    d.base_color[3] = alpha;
    d.alpha_mode = SIDERAY_BLEND;
    d.blend_mode = SIDERAY_BLEND_PREMULTIPLIED;
    d.double_sided = 1;
    return d;
  }

  void panes() {
    m_.window = b_.material("window glass", pane({0.04f, 0.06f, 0.07f}, 0.10f), RayTraced::yes);
    m_.vitrine = b_.material("vitrine glass", pane({0.10f, 0.16f, 0.15f}, 0.08f), RayTraced::yes);
    static constexpr vec3 tints[] = {{1.0f, 0.78f, 0.40f}, {0.55f, 0.85f, 0.60f}, {0.95f, 0.42f, 0.30f}};
    static constexpr const char* names[] = {"stained glass amber", "stained glass green", "stained glass red"};
    for (size_t i = 0; i < 3; ++i) {
      Desc d = glass_material(tints[i], 0.10f);
      m_.stained[i] = b_.material(names[i], d, RayTraced::yes);
    }
    // A silvered pane is opaque, but blended so that it can be ray traced as a layer.
    Desc mirror = pane({0.62f, 0.56f, 0.48f}, 1.0f);
    mirror.metallic = 1.0f;
    m_.mirror = b_.material("antique mirror", mirror, RayTraced::yes);
  }

  void street() {
    m_.cobbles = b_.material("wet cobbles", mapped(paint_cobbles(b_)));
    m_.pavement = b_.material("pavement", dim({0.16f, 0.165f, 0.18f}, 0.3f, street_ambient));
    const Maps ashlar = paint_ashlar(b_);
    static constexpr vec3 tints[] = {{1.0f, 0.92f, 0.82f}, {0.95f, 0.74f, 0.60f}, {0.9f, 0.92f, 0.98f}};
    for (size_t i = 0; i < 3; ++i) m_.facades[i] = b_.material("facade " + std::to_string(i), mapped(ashlar, tints[i]));
    Desc sky = opaque_material(vec3(1), 1.0f);
    sky.base_color_texture.texture = paint_sky(b_);
    sky.unlit = 1;
    sky.double_sided = 1;
    m_.sky = b_.material("dusk sky", sky);
    Desc lit = dim(vec3(0.2f), 0.3f, street_ambient);
    lit.emissive_texture.texture = paint_lit_window(b_);
    set(lit.emissive, vec3(3.0f, 2.6f, 2.0f));
    m_.lit_window = b_.material("lit window", lit);
    m_.dark_window = b_.material("dark window", dim({0.02f, 0.025f, 0.035f}, 0.08f, street_ambient));
    m_.shopfront = b_.material("shopfront", dim({0.05f, 0.13f, 0.17f}, 0.35f, street_ambient));
    m_.awning = b_.material("awning", dim({0.55f, 0.09f, 0.06f}, 0.8f, street_ambient));
    Desc globe = dim(vec3(0.8f), 0.3f);
    set(globe.emissive, {16.0f, 17.5f, 18.5f});
    m_.street_globe = b_.material("street lamp globe", globe);
  }

  ContentBuilder& b_;
  Materials m_{};
  uint32_t shade_ = 0;
};

}  // namespace

Materials make_materials(ContentBuilder& b) {
  return Palette(b).make();
}

}  // namespace sideray::scenes::bistro
