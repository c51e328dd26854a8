// Compares the rasterizer's particles with those of rays in whole frames, and tests what each mode shows of them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

// Unlit panes in front of a wall, and sprites in front of, between and behind them; some are outside the picture.
struct Scenery {
  scenes::Content content;
  size_t sprites = 0;
};

struct Kind {
  sideray_blend_mode blend = SIDERAY_BLEND_ALPHA;
  bool soft = false, lit = false, textured = false;
};

uint32_t add_flip_book(scenes::Content& content) {
  scenes::Texture book;
  book.name = "flip-book";
  book.width = book.height = 16;
  for (uint32_t y = 0; y < 16; ++y)
    for (uint32_t x = 0; x < 16; ++x) {
      const bool corner = x % 8 < 2 && y % 8 < 2;
      for (const uint32_t v : {40 + 12 * x, 255 - 10 * y, 30 + 60 * (x / 8) + 100 * (y / 8), corner ? 0u : 255u})
        book.rgba.push_back(static_cast<uint8_t>(v));
    }
  content.textures.push_back(book);
  return static_cast<uint32_t>(content.textures.size());
}

void add_system(Scenery& scenery, const Kind& kind, int count, uint32_t state) {
  const auto random = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  scenes::Emitter emitter{};
  emitter.node = "system";
  emitter.particles.desc = sideray_particles_defaults();
  emitter.particles.desc.blend_mode = kind.blend;
  emitter.particles.desc.soft_distance = kind.soft ? 1.5f : 0.0f;
  emitter.particles.desc.lit = kind.lit;
  if (kind.textured) {
    emitter.texture = add_flip_book(scenery.content);
    emitter.particles.desc.columns = emitter.particles.desc.rows = 2;
  }
  for (int i = 0; i < count; ++i) {
    sideray_sprite s{};
    s.position[2] = -2.2 - 4.5 * double{random()};
    for (int c = 0; c < 2; ++c) s.position[c] = (double{random()} - 0.5) * 0.9 * -s.position[2];
    s.width = 0.2f + 0.5f * random();
    s.height = 0.2f + 0.5f * random();
    s.rotation = 6.0f * random();
    for (float& c : s.color) c = 0.1f + 0.5f * random();
    s.cell = 4.0f * random();
    emitter.sprites.push_back(s);
  }
  scenery.sprites += emitter.sprites.size();
  scenery.content.emitters.push_back(emitter);
}

Scenery scenery(bool with_light = false) {
  Scenery s{scenes::generate("panes", {{"count", "3"}, {"gap", "1"}}), 0};
  for (scenes::Material& m : s.content.materials) {
    m.desc.unlit = 1;
    m.desc.base_color_texture.texture = 0;  // opaque surfaces are the same in every mode
  }
  if (!with_light) s.content.lights.clear();
  return s;
}

Setup small(sideray_translucency translucency, uint32_t layers = 0) {
  Setup setup{.width = 160, .height = 90, .translucency = translucency};
  setup.layers = layers;
  setup.sky = false;
  setup.light_samples = 2;
  return setup;
}

Setup by_rays(uint32_t events = 0) {
  tests::Setup setup = small(SIDERAY_TRANSLUCENCY_RAYTRACED, events);
  setup.rt_particles = true;
  return setup;
}

// Counts pixels that differ by more than `tolerance` in a channel.
size_t differing(const Frame& a, const Frame& b, float tolerance) {
  const std::vector<float> x = a.rgb(), y = b.rgb();
  size_t count = 0;
  for (size_t i = 0; i < x.size(); i += 3)
    count +=
        std::max({std::abs(x[i] - y[i]), std::abs(x[i + 1] - y[i + 1]), std::abs(x[i + 2] - y[i + 2])}) > tolerance;
  return count;
}

// Composites are half floats: radiance and transmittance below 2 have errors of 2^-11, times their factors.
constexpr float half_steps = 3.0f * 0x1p-11f;
// A pixel whose centre is on a sprite's outline up to rounding may be on either side.
constexpr size_t on_outlines = 8;

TEST(ParticleFrames, HardUnlitSpritesAreTheSameByRasterRaysAndReference) {
  Scenery s = scenery();
  add_system(s, {.blend = SIDERAY_BLEND_ALPHA}, 60, 1);
  add_system(s, {.blend = SIDERAY_BLEND_ADDITIVE}, 40, 2);
  add_system(s, {.blend = SIDERAY_BLEND_PREMULTIPLIED}, 40, 3);
  const Frame raster = render(s.content, small(SIDERAY_TRANSLUCENCY_RASTER)), rays = render(s.content, by_rays()),
              exact = render(s.content, small(SIDERAY_TRANSLUCENCY_REFERENCE));
  tests::Setup reference = small(SIDERAY_TRANSLUCENCY_RASTER);
  reference.reference = true;
  EXPECT_LE(differing(raster, rays, half_steps), on_outlines);
  EXPECT_LE(differing(raster, exact, half_steps), on_outlines);
  EXPECT_LE(differing(rays, exact, half_steps), on_outlines);
  EXPECT_LE(differing(raster, render(s.content, reference), half_steps), on_outlines);
  // The sprites do matter.
  tests::Setup without = by_rays();
  without.rt_particles = false;
  EXPECT_GT(differing(rays, render(s.content, without), 0.05f), 4000u);
}

TEST(ParticleFrames, FlipBooksFadesAndOrthographicViewsAgreeToo) {
  Scenery s = scenery();
  add_system(s, {.soft = true, .textured = true}, 60, 4);
  add_system(s, {.blend = SIDERAY_BLEND_PREMULTIPLIED, .soft = true, .textured = true}, 40, 5);
  for (const bool orthographic : {false, true}) {
    sideray_camera& camera = s.content.cameras[0].camera;
    camera.orthographic = orthographic;
    camera.half_height = 1.8f;
    if (orthographic) camera.z_far = 50;
    const Frame raster = render(s.content, small(SIDERAY_TRANSLUCENCY_RASTER));
    tests::Setup reference = small(SIDERAY_TRANSLUCENCY_RASTER);
    reference.reference = true;
    // The texture unit blends texels in steps of 2^-8 of their differences, up to twenty of them over each other.
    const float filter_steps = half_steps + 20 * 0.25f * 0x1p-8f * 0.5f;
    EXPECT_LE(differing(raster, render(s.content, by_rays()), filter_steps), on_outlines) << orthographic;
    EXPECT_LE(differing(raster, render(s.content, reference), filter_steps), on_outlines) << orthographic;
  }
}

TEST(ParticleFrames, LitSpritesAreTheSameByRasterAndRays) {
  Scenery s = scenery(true);
  add_system(s, {.lit = true}, 60, 6);
  tests::Setup raster = small(SIDERAY_TRANSLUCENCY_RASTER), rays = by_rays();
  raster.shadows = rays.shadows = SIDERAY_SHADOWS_OFF;
  raster.sky = rays.sky = true;
  EXPECT_LE(differing(render(s.content, raster), render(s.content, rays), 2 * half_steps), on_outlines);
}

TEST(ParticleFrames, RaysDropParticlesAndCountThem) {
  Scenery s = scenery();
  add_system(s, {}, 50, 7);
  // Sprites beside the picture, behind the eye, and one at the picture's edge.
  std::vector<sideray_sprite>& sprites = s.content.emitters[0].sprites;
  for (const double x : {-9.0, 9.0}) sprites.push_back(sprites[0]), sprites.back().position[0] = x;
  sprites.push_back(sprites[0]), sprites.back().position[2] = 3.0;
  const double edge = 4.0 * std::tan(0.5 * double{s.content.cameras[0].camera.yfov});
  sprites.push_back(sprites[0]);
  sprites.back().position[0] = 0, sprites.back().position[1] = edge + 0.05, sprites.back().position[2] = -4.0;
  sprites.back().rotation = 0, sprites.back().height = 0.2f;
  size_t in_view = 0;
  const double tangent = std::tan(0.5 * double{s.content.cameras[0].camera.yfov});
  for (const sideray_sprite& sprite : sprites) {
    const double depth = -sprite.position[2], half = 0.5 * std::hypot(double{sprite.width}, double{sprite.height});
    in_view += depth > 0 && std::abs(sprite.position[1]) - half < depth * tangent &&
               std::abs(sprite.position[0]) - half < depth * tangent * 16.0 / 9.0;
  }
  tests::Setup dropped = small(SIDERAY_TRANSLUCENCY_RAYTRACED, 2), met = by_rays(2);
  dropped.repeats = met.repeats = 1;
  EXPECT_EQ(in_view, 51u);
  EXPECT_EQ(render(s.content, dropped).stats.dropped_particles, in_view);
  EXPECT_EQ(render(s.content, met).stats.dropped_particles, 0u);
  // They are also dropped where no ray starts at all.
  s.content.objects.resize(1);
  EXPECT_EQ(render(s.content, dropped).stats.dropped_particles, in_view);
  tests::Setup hybrid = small(SIDERAY_TRANSLUCENCY_HYBRID, 4);
  hybrid.repeats = 1;
  EXPECT_EQ(render(s.content, hybrid).stats.dropped_particles, 0u);
}

TEST(ParticleFrames, HybridDrawsThemAsRasterDoesAndOffDrawsNone) {
  Scenery s = scenery();
  add_system(s, {.soft = true, .textured = true}, 60, 8);
  EXPECT_LE(differing(render(s.content, small(SIDERAY_TRANSLUCENCY_HYBRID, 4)),
                      render(s.content, small(SIDERAY_TRANSLUCENCY_RASTER)), half_steps),
            on_outlines);
  const Frame off = render(s.content, small(SIDERAY_TRANSLUCENCY_OFF));
  s.content.emitters.clear();
  EXPECT_EQ(off.rgb(), render(s.content, small(SIDERAY_TRANSLUCENCY_OFF)).rgb());
}

// Masks include sprites, so that rays start at every sprite: without a mask the picture has the same bits.
TEST(ParticleFrames, MasksHideNoParticlesFromRays) {
  Scenery s = scenery();
  add_system(s, {.soft = true, .textured = true}, 60, 9);
  tests::Setup none = by_rays(8);
  none.mask = SIDERAY_NO_MASK;
  const Frame every_pixel = render(s.content, none);
  for (const sideray_mask mask : {SIDERAY_STENCIL_MASK, SIDERAY_COUNT_MASK}) {
    tests::Setup masked = by_rays(8);
    masked.mask = mask;
    EXPECT_LE(differing(every_pixel, render(s.content, masked), 0.0f), on_outlines);
  }
}

// Surfaces beyond the last event are missing: the hole that the chapter describes.
TEST(ParticleFrames, SurfacesBeyondTheLastEventAreMissing) {
  Scenery s = scenery();
  add_system(s, {}, 400, 10);
  const Frame all = render(s.content, by_rays());
  size_t before = std::numeric_limits<size_t>::max();
  for (const uint32_t events : {1u, 4u, 8u}) {
    const size_t wrong = differing(all, render(s.content, by_rays(events)), half_steps);
    EXPECT_LT(wrong, before) << events;
    before = wrong;
  }
  EXPECT_GT(before, 0u);
  EXPECT_EQ(differing(all, render(s.content, by_rays(64)), half_steps), 0u);
}

TEST(ParticleFrames, ThreadsAndContextsDoNotChangeThem) {
  Scenery s = scenery();
  add_system(s, {.soft = true, .textured = true}, 60, 11);
  tests::Setup one = by_rays(8), many = by_rays(8);
  one.threads = 1, many.threads = 4;
  EXPECT_EQ(render(s.content, one).rgb(), render(s.content, many).rgb());
}

}  // namespace
}  // namespace sideray::tests
