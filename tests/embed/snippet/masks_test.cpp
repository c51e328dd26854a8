// Tests sideray_shadow() and sideray_ao() in a host's shader: they are the service's masks, and 1 everywhere else.
#include <gtest/gtest.h>
#include <sideray/diagnostics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>
#include <sideray/sideray.hpp>

#include "embed/hosts/wall_host.h"

namespace sideray::tests::snippet_masks_test {
namespace {

constexpr int left = 8, bottom = 4, masked_width = 72, masked_height = 48;
constexpr uint32_t sentinel_unit_count = 6;
using Texels = std::vector<std::array<uint8_t, 4>>;

void add_quad(sideray::Scene& scene, sideray_material material, double x, double z, double size) {
  const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = positions;
  mesh.index_count = 6;
  mesh.indices = indices;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = material;
  for (int i : {0, 4, 8}) instance.world_from_object[i] = size;
  instance.world_from_object[9] = x;
  instance.world_from_object[11] = z;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

// Returns a wall at z = 0, a plate behind the eye to the left, and four lights that cast its shadow to four places.
sideray::Scene wall_and_plate() {
  sideray::Scene scene = sideray::Scene::create().value();
  sideray_material_desc white = sideray_material_defaults();
  white.double_sided = 1;
  const sideray_material material = scene.add_material(white);
  add_quad(scene, material, 0, 0, 5);
  add_quad(scene, material, -0.5, 0.5, 0.4);
  std::vector<sideray_light> lights(4);
  for (size_t i = 0; i < lights.size(); ++i) {
    lights[i].size = sizeof(lights[i]);
    lights[i].type = SIDERAY_LIGHT_DIRECTIONAL;
    lights[i].direction[0] = 0.5f * static_cast<float>(i);
    lights[i].direction[2] = -1;
    for (float& c : lights[i].intensity) c = 1;
  }
  scene.set_lights(lights);
  scene.commit();
  return scene;
}

class SnippetMasks : public WallHost {
 protected:
  SnippetMasks() : WallHost(GL_RGBA8) {
    serve(tracer_);
    program_ = make_program("result = vec4(sideray_shadow(0), sideray_shadow(1), sideray_shadow(3), sideray_ao());");
  }

  FrameInputs masks_of(uint32_t lights, uint32_t ao_rays) {
    FrameInputs in = frame_of(left, bottom, masked_width, masked_height);
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = lights;
    in.masks->ao_rays = ao_rays;
    return in;
  }

  using WallHost::trace;
  void trace(uint32_t lights, uint32_t ao_rays) { trace(masks_of(lights, ao_rays)); }

  Texels draw(const gl::Program& program) {
    const gl::Functions& gl = context_->functions();
    EXPECT_EQ(sideray_service_bind(service_->get(), 0, program.id(), first_unit, nullptr), SIDERAY_OK);
    program.use();
    gl.BindVertexArray(array_.id());
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_DEPTH_TEST);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    Texels texels(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    return texels;
  }

  sideray_mask_outputs latest() {
    sideray_mask_outputs outputs{};
    outputs.size = sizeof(outputs);
    EXPECT_EQ(sideray_service_masks(service_->get(), 0, &outputs, nullptr), SIDERAY_OK);
    return outputs;
  }

  std::vector<uint8_t> texels_of(GLenum target, uint32_t texture, size_t layers) {
    const gl::Functions& gl = context_->functions();
    std::vector<uint8_t> values(layers * masked_width * masked_height);
    gl.BindTexture(target, texture);
    gl.GetTexImage(target, 0, GL_RED, GL_UNSIGNED_BYTE, values.data());
    gl.BindTexture(target, 0);
    return values;
  }

  sideray::Scene scene_ = wall_and_plate();
  sideray::Tracer tracer_ = sideray::Tracer::create(scene_).value();
};

TEST_F(SnippetMasks, AreReadByTheLightsPlaces) {
  trace(0b1010, 4);
  const std::vector<uint8_t> lit = texels_of(GL_TEXTURE_2D_ARRAY, latest().shadow_texture, 2);
  const std::vector<uint8_t> open = texels_of(GL_TEXTURE_2D, latest().ao_texture, 1);
  const Texels texels = draw(*program_);
  std::array<std::set<uint8_t>, 4> values;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::array<uint8_t, 4>& texel = texels[static_cast<size_t>(y * width + x)];
      const int i = x - left, j = y - bottom;
      const bool inside = i >= 0 && j >= 0 && i < masked_width && j < masked_height;
      const auto at = static_cast<size_t>(j * masked_width + i), layer = size_t{masked_width} * masked_height;
      const std::array<uint8_t, 4> expected = inside ? std::array<uint8_t, 4>{255, lit[at], lit[layer + at], open[at]}
                                                     : std::array<uint8_t, 4>{255, 255, 255, 255};
      ASSERT_EQ(texel, expected) << x << "," << y;
      for (size_t c = 0; c < 4; ++c) values[c].insert(texel[c]);
    }
  EXPECT_EQ(values[1], (std::set<uint8_t>{0, 255}));
  EXPECT_EQ(values[2], (std::set<uint8_t>{0, 255}));
  EXPECT_GT(values[3].size(), 2u);
  EXPECT_FALSE(
      std::equal(lit.begin(), lit.begin() + masked_width * masked_height, lit.begin() + masked_width * masked_height));
}

TEST_F(SnippetMasks, AnswerOneWithoutMasks) {
  const Texels all_one(size_t{width} * height, {255, 255, 255, 255});
  EXPECT_EQ(draw(*program_), all_one) << "before the first frame";
  trace(0b1010, 0);
  EXPECT_NE(draw(*program_), all_one);
  trace(0, 4);
  const Texels ao_alone = draw(*program_);
  EXPECT_NE(ao_alone, all_one);
  for (const std::array<uint8_t, 4>& texel : ao_alone) ASSERT_EQ(texel[1], 255);
}

TEST_F(SnippetMasks, AreShownAsColours) {
  const auto shows_1 = make_program("result = vec4(sideray_debug_masks(1), 1.0);");
  const auto shows_0 = make_program("result = vec4(sideray_debug_masks(0), 1.0);");
  const std::array<uint8_t, 4> magenta = {255, 0, 255, 255};
  trace(0b1010, 4);
  const Texels seen = draw(*shows_1), shares = draw(*program_);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto at = static_cast<size_t>(y * width + x);
      const int i = x - left, j = y - bottom;
      const bool inside = i >= 0 && j >= 0 && i < masked_width && j < masked_height;
      const std::array<uint8_t, 4> expected = inside ? std::array<uint8_t, 4>{shares[at][1], shares[at][3], 0, 255} : magenta;
      ASSERT_EQ(seen[at], expected) << x << "," << y;
    }
  EXPECT_EQ(draw(*shows_0), Texels(seen.size(), magenta)) << "a light without a mask";
}

// Under a budget of one piece the sky is known everywhere, by a few samples a tile, and a light's mask in one tile
// alone: elsewhere the host uses its own shadow map.
TEST_F(SnippetMasks, UnderABudgetLeaveTheRestToTheHost) {
  const auto program = make_program(
      "result = vec4(sideray_shadow_or(1, 0.25), sideray_shadow_or(0, 0.5), sideray_ao_or(0.75), sideray_shadow_color_or(3, vec3(0.25)).y);");
  FrameInputs in = masks_of(0b1010, 16);
  in.masks->denoise = 0;
  trace(in);
  EXPECT_EQ(latest().answer_texture, 0u);
  const Texels whole = draw(*program);
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  diagnostics.budget_pieces = 1;
  in.frame.diagnostics = &diagnostics;
  service_.emplace(sideray::Service::create(tracer_, {sizeof(sideray_host_gl), gl::Context::get_proc_address, context_.get()}).value());
  trace(in);
  ASSERT_NE(latest().answer_texture, 0u);
  const std::vector<uint8_t> answers = texels_of(GL_TEXTURE_2D, latest().answer_texture, 1);
  const Texels some = draw(*program);
  int known = 0;
  double error = 0.0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto at = static_cast<size_t>(y * width + x);
      const int i = x - left, j = y - bottom;
      if (i < 0 || j < 0 || i >= masked_width || j >= masked_height) {
        ASSERT_EQ(some[at], (std::array<uint8_t, 4>{64, 128, 191, 64})) << x << ',' << y;
        continue;
      }
      const uint8_t answer = answers[static_cast<size_t>(j * masked_width + i)];
      EXPECT_TRUE(answer & 2) << x << ',' << y;
      const bool lit = (answer & 1) != 0;
      known += lit;
      EXPECT_EQ(some[at][0], lit ? whole[at][0] : 64) << x << ',' << y;
      EXPECT_EQ(some[at][1], 128) << "no mask was asked for";
      EXPECT_EQ(some[at][3], lit ? whole[at][3] : 64) << x << ',' << y;
      error += std::abs(int{some[at][2]} - int{whole[at][2]}) / 255.0;
    }
  EXPECT_GT(known, 0);
  EXPECT_LT(known, masked_width * masked_height / 2);
  EXPECT_LT(error / (masked_width * masked_height), 0.08) << "of the sky's shares, which are 16 random directions each";
}

TEST_F(SnippetMasks, LampsThatAddTooLittleHaveNoRays) {
  std::vector<sideray_light> lamps(4);
  for (size_t i = 0; i < lamps.size(); ++i) {
    lamps[i].size = sizeof(lamps[i]);
    lamps[i].type = SIDERAY_LIGHT_POINT;
    lamps[i].position[0] = -0.5 - 0.2 * static_cast<double>(i);
    lamps[i].position[1] = 0.5;
    lamps[i].position[2] = 2;
    for (float& c : lamps[i].intensity) c = 1;
  }
  scene_.set_lights(lamps);
  scene_.commit();
  trace(0b1010, 0);
  const std::vector<uint8_t> each = texels_of(GL_TEXTURE_2D_ARRAY, latest().shadow_texture, 2);
  EXPECT_EQ(std::set<uint8_t>(each.begin(), each.end()), (std::set<uint8_t>{0, 255}));
  FrameInputs in = masks_of(0b1010, 0);
  in.masks->least_light = 1e6f;
  trace(in);
  const std::vector<uint8_t> none = texels_of(GL_TEXTURE_2D_ARRAY, latest().shadow_texture, 2);
  EXPECT_EQ(std::set<uint8_t>(none.begin(), none.end()), (std::set<uint8_t>{255}));
}

// A pane of thin coloured glass in front of the wall's right half casts a coloured shadow of the third light.
TEST_F(SnippetMasks, TintsAreThoseOfGlassInTheWay) {
  const auto tints = make_program("result = vec4(sideray_shadow_tint(1), sideray_shadow(1));");
  const auto colors = make_program("result = vec4(sideray_shadow_color(1), 1.0);");
  trace(0b1010, 0);
  EXPECT_EQ(latest().tint_texture, 0u);
  for (const int32_t layer : latest().tint_layers) EXPECT_EQ(layer, 0);
  const Texels before = draw(*tints);
  for (const std::array<uint8_t, 4>& texel : before) ASSERT_EQ((std::array{texel[0], texel[1], texel[2]}), (std::array<uint8_t, 3>{255, 255, 255}));
  sideray_material_desc pane = sideray_material_defaults();
  pane.transmission = 1;
  pane.roughness = 0;
  const float color[3] = {0.9f, 0.5f, 0.1f};
  for (int c = 0; c < 3; ++c) pane.base_color[c] = color[c];
  add_quad(scene_, scene_.add_material(pane), 0.7, 0.5, 0.4);
  scene_.commit();
  trace(0b1010, 0);
  ASSERT_NE(latest().tint_texture, 0u);
  EXPECT_EQ(latest().tint_layers[0], 0);
  EXPECT_EQ(latest().tint_layers[1], 1);
  EXPECT_EQ(latest().tint_layers[3], 4);
  EXPECT_EQ(latest().tint_layers[32], 0);
  // The light comes from (-0.5, 0, 1) to the pane, which reflects by Schlick's term.
  const double cosine = 1 / std::sqrt(1.25), passed = 0.96 * (1 - std::pow(1 - cosine, 5));
  std::array<uint8_t, 4> expected{0, 0, 0, 255};
  for (size_t c = 0; c < 3; ++c) expected[c] = static_cast<uint8_t>(static_cast<double>(color[c]) * passed * 255 + 0.5);
  const Texels after = draw(*tints), both = draw(*colors);
  size_t tinted = 0;
  for (size_t i = 0; i < after.size(); ++i) {
    ASSERT_EQ(after[i][3], before[i][3]) << "the mask of what is opaque stays";
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(both[i][c], after[i][c] * after[i][3] / 255, 1);
    if (after[i][0] == 255) continue;
    ++tinted;
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(after[i][c], expected[c], 1);
  }
  // The shadow covers 0.8 x 0.8 of the wall; the rectangle shows the whole view.
  const double seen = 3.0 * std::tan(0.45) * 2;
  EXPECT_NEAR(static_cast<double>(tinted) / (masked_width * masked_height), 0.64 / (seen * seen * width / height), 0.02);
  scene_.set_visibility(3, SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_SHADOW);
  scene_.commit();
  trace(0b1010, 0);
  EXPECT_EQ(latest().tint_texture, 0u);
  EXPECT_EQ(draw(*tints), before);
}

// Nothing in the scene is translucent, so that the sky's visibility past opaque surfaces is all of its light.
TEST_F(SnippetMasks, TheSkyThatNothingOpaqueHidesIsTheLastLayer) {
  FrameInputs in = masks_of(0b1010, 4);
  EXPECT_EQ((trace(in), latest().unhidden_sky), 0);
  in.masks->unhidden_sky = 1;
  trace(in);
  EXPECT_EQ(latest().unhidden_sky, 1);
  const std::vector<uint8_t> layers = texels_of(GL_TEXTURE_2D_ARRAY, latest().shadow_texture, 3);
  const std::vector<uint8_t> open = texels_of(GL_TEXTURE_2D, latest().ao_texture, 1);
  const auto last = layers.begin() + 2 * masked_width * masked_height;
  EXPECT_EQ(std::vector<uint8_t>(last, layers.end()), open);
  EXPECT_GT(std::set<uint8_t>(open.begin(), open.end()).size(), 2u);
}

TEST_F(SnippetMasks, WhatCannotBeIsRefused) {
  const auto refusal = [&](const FrameInputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(service_->get(), in, ticket, &error), SIDERAY_INVALID_ARGUMENT);
    return std::string(error.message);
  };
  FrameInputs sky = masks_of(0b1010, 0), light = sky, samples = sky;
  sky.masks->unhidden_sky = 1;
  EXPECT_EQ(refusal(sky).find("masks unhidden_sky: "), 0u);
  light.masks->least_light = std::nanf("");
  EXPECT_EQ(refusal(light).find("masks least_light nan: "), 0u);
  samples.layers = sideray_layer_inputs_defaults();
  samples.layers->light_samples = 4;
  EXPECT_EQ(refusal(samples).find("layers light_samples 4: a cache holds no reference"), 0u);
}

// Programs written for three units keep the others.
TEST_F(SnippetMasks, UnitsAreBoundOnlyForThoseWhoRead) {
  trace(0b1010, 4);
  const gl::Functions& gl = context_->functions();
  const auto bound = [&](uint32_t unit, GLenum binding) {
    GLint texture = 0;
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    gl.GetIntegerv(binding, &texture);
    return static_cast<uint32_t>(texture);
  };
  const auto layers_alone = make_program("result = vec4(sideray_translucent(vec3(1.0), gl_FragCoord.xyz, 1u), 1.0);");
  draw(*layers_alone);
  for (uint32_t unit = first_unit + 3; unit < first_unit + sentinel_unit_count; ++unit) {
    EXPECT_EQ(bound(unit, GL_TEXTURE_BINDING_2D_ARRAY), 0u);
    EXPECT_EQ(bound(unit, GL_TEXTURE_BINDING_2D), 0u);
  }
  draw(*program_);
  EXPECT_EQ(bound(first_unit + 3, GL_TEXTURE_BINDING_2D_ARRAY), latest().shadow_texture);
  EXPECT_EQ(bound(first_unit + 4, GL_TEXTURE_BINDING_2D), latest().ao_texture);
  EXPECT_EQ(bound(first_unit + 7, GL_TEXTURE_BINDING_2D_ARRAY), 0u);
}

// A host that draws the wall with and without a lamp, in a space and with fog for which no factor makes the shadow.
class TwoPictures : public SnippetMasks {
 protected:
  // Returns the point of the wall in a pixel of the framebuffer.
  static glm::dvec2 place(int x, int y) {
    const glm::dvec2 ndc((x - left + 0.5) / masked_width * 2 - 1, (y - bottom + 0.5) / masked_height * 2 - 1);
    return ndc * 3.0 * std::tan(0.45) * glm::dvec2(double{width} / height, 1);
  }
  static std::string shading() {
    const auto text = [](double v) { return std::to_string(v); };
    return "vec2 at = ((gl_FragCoord.xy - vec2(" + text(left) + ", " + text(bottom) + ")) / vec2(" + text(masked_width) + ", " +
           text(masked_height) + ") * 2.0 - 1.0) * " + text(3 * std::tan(0.45)) + " * vec2(" + text(double{width} / height) +
           ", 1.0);\n"
           "float texture_at = 0.5 + 0.3 * sin(5.0 * at.x) * cos(4.0 * at.y), fog = exp(-0.2 * dot(at, at));\n"
           "vec4 lamps = vec4(0.4, 0.3, 0.25, 0.2) / (1.0 + 0.3 * dot(at, at)) * texture_at;\n"
           "float ambient = 0.2 * texture_at;\n";
  }
  struct Lit {
    double ambient, fog;
    std::array<double, 4> lamps;
  };
  static Lit lit(glm::dvec2 p) {
    const double texture = 0.5 + 0.3 * std::sin(5 * p.x) * std::cos(4 * p.y), near = texture / (1 + 0.3 * glm::dot(p, p));
    return {0.2 * texture, std::exp(-0.2 * glm::dot(p, p)), {0.4 * near, 0.3 * near, 0.25 * near, 0.2 * near}};
  }
  static double shown(double light, double fog) { return 0.7 + fog * (std::pow(light, 1 / 2.2) - 0.7); }
  // Says whether the plate occludes the light, and how far the shadow's edge is.
  struct Shadow {
    bool hidden;
    double margin;
  };
  static Shadow shadow(glm::dvec2 p, size_t light) {
    const glm::dvec2 from_middle = glm::abs(glm::dvec2(p.x - 0.25 * static_cast<double>(light) + 0.5, p.y)) - 0.4;
    const double outside = std::max(from_middle.x, from_middle.y);
    return {outside < 0, std::abs(outside)};
  }
  // Compares all pixels of the rectangle whose shadows are sure, and returns how many are in some shadow.
  template <typename Expected>
  static size_t compare(const Texels& texels, size_t lights, const Expected& expected) {
    size_t dark = 0;
    for (int y = bottom; y < bottom + masked_height; ++y)
      for (int x = left; x < left + masked_width; ++x) {
        const glm::dvec2 p = place(x, y);
        std::array<bool, 4> hidden{};
        bool sure = true;
        for (size_t i = 0; i < lights; ++i) hidden[i] = shadow(p, i).hidden, sure &= shadow(p, i).margin > 0.065;  // a pixel is 0.06 wide
        if (!sure) continue;
        dark += std::count(hidden.begin(), hidden.end(), true) > 0;
        const double got = texels[static_cast<size_t>(y * width + x)][0];
        EXPECT_NEAR(got, 255 * std::clamp(expected(lit(p), hidden), 0.0, 1.0), 1.0) << x << "," << y;
      }
    return dark;
  }
};

TEST_F(TwoPictures, MixedByTheShadowAreExactInAnySpace) {
  trace(0b0001, 0);
  const auto program = make_program(shading() +
                                    "float without_light = mix(0.7, pow(ambient, 1.0 / 2.2), fog);\n"
                                    "float with_light = mix(0.7, pow(ambient + lamps.x, 1.0 / 2.2), fog);\n"
                                    "result = vec4(mix(without_light, with_light, sideray_shadow(0)));");
  const size_t dark = compare(draw(*program), 1, [](const Lit& l, const std::array<bool, 4>& hidden) {
    return shown(l.ambient + (hidden[0] ? 0 : l.lamps[0]), l.fog);
  });
  EXPECT_GT(dark, 50u);
}

TEST_F(TwoPictures, OfSeveralLampsAddUp) {
  trace(0b1111, 0);
  const auto program = make_program(shading() +
                                    "float base = ambient, sum = base;\n"
                                    "for (int i = 0; i < 4; ++i) sum += (base + lamps[i] - base) * sideray_shadow(i);\n"
                                    "result = vec4(sum);");
  const size_t dark = compare(draw(*program), 4, [](const Lit& l, const std::array<bool, 4>& hidden) {
    double light = l.ambient;
    for (size_t i = 0; i < 4; ++i) light += hidden[i] ? 0 : l.lamps[i];
    return light;
  });
  EXPECT_GT(dark, 100u);
}

}  // namespace
}  // namespace sideray::tests::snippet_masks_test
