// Tests what glass of the fixed function shows: shadows, both sides, shortcuts; and which input is refused.
#include <gmock/gmock.h>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

constexpr float code = 1.0f / 255;

// Tests a pane, with or without an opaque wall between it and a light.
class FixedPane : public testing::Test {
 protected:
  static constexpr size_t middle = size_t{GlassHost::height / 2} * GlassHost::width + GlassHost::width / 2;
  FixedPane() : depth_(host.gl) {
    host.attach(depth_);
    light_.position[0] = 0.5, light_.position[1] = 0.3, light_.position[2] = 4, light_.position[3] = 1;
    for (int c = 0; c < 3; ++c) light_.diffuse[c] = 0.5f, light_.ambient[c] = 0.25f, light_.specular[c] = 0.2f;
    for (int c = 0; c < 3; ++c) material_.diffuse[c] = material_.ambient[c] = 1, material_.specular[c] = 0.5f;
    material_.shininess = 1;
    for (float& c : model_.ambient) c = 0;
    commit();
  }
  void commit() {
    model_.lights = &light_, model_.light_count = 1;
    host.scene().set_fixed_material(host.pane_desc().material, material_);
    host.scene().set_fixed_function(model_);
    host.scene().commit();
  }
  sideray_instance put_wall() {
    sideray_instance_desc wall = host.pane_desc();
    sideray_material_desc desc = sideray_material_defaults();
    desc.double_sided = 1;
    wall.material = host.scene().add_material(desc);
    wall.surface_id = 9, wall.visibility = SIDERAY_VISIBLE_SHADOW;
    wall.world_from_object[11] = 3.5;
    const sideray_instance instance = host.scene().add_instances({&wall, 1}).front();
    host.scene().commit();
    return instance;
  }
  GlassHost::Picture shown(const FrameInputs& in) {
    host.trace(in);
    return host.draw(program_, 330);
  }
  GlassHost::Picture shown() { return shown(host.inputs()); }

  GlassHost host;
  sideray_fixed_light light_ = sideray_fixed_light_defaults();
  sideray_fixed_material material_ = sideray_fixed_material_defaults();
  sideray_fixed_function model_ = sideray_fixed_function_defaults();

 private:
  gl::Renderbuffer depth_;

 protected:
  gl::Program program_ = host.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)");
};

TEST_F(FixedPane, ShadowsTakeDirectLightAlone) {
  for (const int separate : {0, 1}) {
    model_.separate_specular = separate;
    light_.casts_shadows = 1;
    commit();
    const float lit = shown()[middle].x;
    EXPECT_GT(lit, 0.7f);
    const sideray_instance wall = put_wall();
    EXPECT_NEAR(shown()[middle].x, 0.25f, code / 2) << "in shadow";
    light_.casts_shadows = 0;
    commit();
    EXPECT_NEAR(shown()[middle].x, lit, code / 2) << "a light without shadows";
    host.scene().remove_instances(std::array{wall});
  }
}

TEST_F(FixedPane, HasTwoSidesWhereTheModelSaysSo) {
  light_.position[2] = -4;
  material_.specular[0] = 0;
  commit();
  EXPECT_NEAR(shown()[middle].x, 0.25f, code / 2) << "lit from behind";
  sideray_instance_desc turned = host.pane_desc();
  turned.world_from_object[0] = -1, turned.world_from_object[8] = -1;
  host.scene().replace_instances(std::array{host.pane()}, std::array{turned});
  commit();
  EXPECT_GT(shown()[middle].x, 0.6f) << "its front looks to the light, its back to the eye";
  model_.two_sided = 1;
  commit();
  EXPECT_NEAR(shown()[middle].x, 0.25f, code / 2) << "its back looks away from the light";
}

// All shortcuts that save rays work as with the built-in model.
TEST_F(FixedPane, HasTheFastWays) {
  put_wall();
  material_.reflectance[0] = 0.3f;
  const std::vector<float> sky(3 * 2 * 2, 0.5f);
  host.scene().set_environment(2, 2, sky.data(), 1.0f, 0.0f);
  for (const int separate : {0, 1}) {
    model_.separate_specular = separate;
    commit();
    FrameInputs in = host.inputs();
    const GlassHost::Picture exact = shown(in);
    in.layers->ray_reuse = 1.0f / 64;
    sideray_ticket ticket = host.service().submit(in).value();
    ASSERT_TRUE(host.service().wait(ticket));
    EXPECT_GT(host.service().stats(ticket).layers_borrowed, 500u);
    const GlassHost::Picture reused = shown(in);
    for (size_t i = 0; i < exact.size(); ++i) ASSERT_NEAR(reused[i].x, exact[i].x, 1.0f / 64 + code) << i;
    std::vector<uint8_t> one(size_t{GlassHost::width} * GlassHost::height, 1);
    in.frame.source.mask = SIDERAY_MASK_MEMORY;
    in.frame.source.mask_texels = one.data(), in.frame.source.mask_row_bytes = GlassHost::width;
    in.layers->whole_pixels = 1;
    ticket = host.service().submit(in).value();
    ASSERT_TRUE(host.service().wait(ticket));
    const uint32_t whole = host.service().layers()->whole_radiance_texture;
    ASSERT_NE(whole, 0u);
    GlassHost::Picture picture(exact.size());
    host.gl.BindTexture(GL_TEXTURE_2D, whole);
    host.gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, picture.data());
    constexpr size_t inside = middle + 9;  // inside a triangle
    EXPECT_NEAR(picture[inside].x, 0.5f * reused[inside].x, code) << "half of it covers";
  }
}

// In a left-handed world the picture of the environment is flipped left to right: docs/fixed-function.md.
TEST_F(FixedPane, MirrorsAFlippedEnvironmentInALeftHandedWorld) {
  constexpr uint32_t columns = 16;
  std::vector<float> sky, flipped;
  for (uint32_t i = 0; i < 2 * columns; ++i) {
    const auto at = [](uint32_t x) { return 0.1f + 0.05f * static_cast<float>(x * x % 17); };
    for (int c = 0; c < 3; ++c) sky.push_back(at(i % columns)), flipped.push_back(at(columns - 1 - i % columns));
  }
  for (float& r : material_.reflectance) r = 0.5f;
  host.scene().set_environment(columns, 2, sky.data(), 1.0f, 0.0f);
  commit();
  const GlassHost::Picture right = shown();
  const glm::dmat4 mirrored = glm::scale(GlassHost::clip_from_world(), glm::dvec3(-1, 1, 1));
  light_.position[0] = -light_.position[0];
  FrameInputs in = host.inputs();
  GlassHost::set_view(in, mirrored);
  const auto most_apart = [&](const std::vector<float>& environment) {
    host.scene().set_environment(columns, 2, environment.data(), 1.0f, 0.0f);
    commit();
    host.trace(in);
    const GlassHost::Picture left = host.draw(program_, 330, mirrored);
    float most = 0;
    for (size_t i = 0; i < right.size(); ++i) most = std::max(most, std::abs(left[i].x - right[i].x));
    return most;
  };
  EXPECT_LT(most_apart(flipped), code);
  EXPECT_GT(most_apart(sky), 0.05f);
}

// A commit copies the caller's structs, which may be freed at once.
TEST_F(FixedPane, IsCopied) {
  const float before = shown()[middle].x;
  light_.diffuse[0] = 0, light_.ambient[0] = 0, material_.diffuse[0] = 0;
  EXPECT_EQ(shown()[middle].x, before);
  commit();
  EXPECT_LT(shown()[middle].x, before - 0.2f);
}

TEST_F(FixedPane, WhatItIsGivenIsChecked) {
  sideray_error error{};
  sideray_scene* scene = host.scene().get();
  const auto refused = [&](sideray_status status, const char* what) {
    EXPECT_EQ(status, SIDERAY_INVALID_ARGUMENT) << what;
    EXPECT_THAT(error.message, testing::HasSubstr(what));
  };
  const auto set_light = [&] { return sideray_scene_set_fixed_function(scene, &model_, &error); };
  const auto set_material = [&] {
    return sideray_scene_set_fixed_material(scene, host.pane_desc().material, &material_, &error);
  };
  light_.spot_cutoff_deg = 120;
  refused(set_light(), "spot_cutoff_deg is 120; give 0 to 90, or 180");
  light_.spot_cutoff_deg = 180, light_.constant_attenuation = 0;
  refused(set_light(), "all its attenuations are 0");
  light_.constant_attenuation = 1, light_.diffuse[1] = -1;
  refused(set_light(), "diffuse holds -1");
  light_.diffuse[1] = 1, light_.position[3] = 0, light_.position[0] = light_.position[1] = light_.position[2] = 0;
  refused(set_light(), "no direction");
  material_.shininess = 129;
  refused(set_material(), "shininess is 129");
  material_.shininess = 1, material_.follows_color = 16;
  refused(set_material(), "SIDERAY_FOLLOW_");
  material_.follows_color = 0, material_.environment = static_cast<sideray_texture_environment>(4);
  refused(set_material(), "environment 4");
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = [](void*, const sideray_shading_point*, size_t, sideray_shading_result*) {};
  refused(sideray_scene_set_shader(scene, &shader, &error), "shaded by the fixed function");
  FrameInputs in = host.inputs();
  in.layers->mode = SIDERAY_COMPOSITE, in.layers->light_samples = 2;
  sideray_ticket ticket = 0;
  const sideray_frame_inputs c = in.c();
  refused(sideray_service_submit(host.service().get(), &c, &ticket, &error), "light_samples 2");
}

}  // namespace
}  // namespace sideray::tests
