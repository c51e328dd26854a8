// Compares scenes of the fixed function, term by term, with the driver's own fixed function.
#include "embed/fixed/fixed_points.h"

namespace sideray::tests {
namespace {

// Each test isolates one term.
class FixedTerms : public FixedFunction {
 protected:
  FixedTerms() {
    dark.model.ambient[0] = dark.model.ambient[1] = dark.model.ambient[2] = 0;
    numbers.color(dark.material.ambient, 1), numbers.color(dark.material.diffuse, 1);
  }
  Look lit_by(const sideray_fixed_light& light) const {
    Look look = dark;
    look.lights.push_back(light);
    return look;
  }
  Look shining(int kind, float exponent) {
    Look look = lit_by(plain_light(kind));
    for (float& c : look.material.diffuse) c *= 0.5f;
    numbers.color(look.material.specular, 1);
    look.material.shininess = exponent;
    return look;
  }
  Look dark;
};

TEST_F(FixedTerms, LightsAndTheirFading) {
  Look look = dark;
  numbers.color(look.model.ambient, 1);
  expect_parity(look, "global ambient");
  look = dark;
  numbers.color(look.material.emission, 1);
  expect_parity(look, "emission");
  look = lit_by(plain_light(0));
  numbers.color(look.lights[0].ambient, 1);
  for (float& c : look.material.diffuse) c = 0;
  expect_parity(look, "ambient of a light");
  expect_parity(lit_by(plain_light(0)), "diffuse, directional");
  expect_parity(lit_by(plain_light(1)), "diffuse, all around");
  look = lit_by(plain_light(1)), look.lights[0].constant_attenuation = 1.7f;
  expect_parity(look, "constant attenuation");
  look = lit_by(plain_light(1)), look.lights[0].constant_attenuation = 0, look.lights[0].linear_attenuation = 0.6f;
  expect_parity(look, "linear attenuation");
  look = lit_by(plain_light(1)), look.lights[0].constant_attenuation = 0, look.lights[0].quadratic_attenuation = 0.3f;
  expect_parity(look, "quadratic attenuation");
  look = lit_by(plain_light(2)), look.lights[0].spot_cutoff_deg = 50;
  expect_parity(look, "spot cutoff");
  look = lit_by(plain_light(2)), look.lights[0].spot_cutoff_deg = 80, look.lights[0].spot_exponent = 9;
  expect_parity(look, "spot exponent");
}

TEST_F(FixedTerms, Highlights) {
  expect_parity(shining(0, 20), "specular, directional");
  expect_parity(shining(1, 0.7f), "specular, all around, wide");
  expect_parity(shining(1, 128), "specular, all around, narrow");
  Look look = shining(1, 12);
  look.model.local_viewer = 1;
  expect_parity(look, "local viewer");
  look = shining(1, 5);
  look.textured = true;
  expect_parity(look, "specular below the texture");
  look.model.separate_specular = 1;
  expect_parity(look, "separate specular colour");
}

TEST_F(FixedTerms, ColorMaterial) {
  Look look = shining(1, 8);
  look.lights[0].ambient[0] = 0.3f, look.colored = true;
  expect_parity(look, "colours that nothing follows");
  for (const uint32_t bits : {SIDERAY_FOLLOW_AMBIENT, SIDERAY_FOLLOW_DIFFUSE, SIDERAY_FOLLOW_AMBIENT_AND_DIFFUSE,
                              SIDERAY_FOLLOW_SPECULAR, SIDERAY_FOLLOW_EMISSION}) {
    look.material.follows_color = bits;
    expect_parity(look, "GL_COLOR_MATERIAL " + std::to_string(bits));
  }
  look.material.follows_color = 0;
  look.unlit = true;
  expect_parity(look, "no lighting");
}

TEST_F(FixedTerms, TextureEnvironments) {
  for (const auto environment : {SIDERAY_ENVIRONMENT_MODULATE, SIDERAY_ENVIRONMENT_DECAL, SIDERAY_ENVIRONMENT_REPLACE,
                                 SIDERAY_ENVIRONMENT_ADD}) {
    Look look = shining(1, 8);
    look.textured = true, look.alpha = 0.7f;
    look.material.environment = environment;
    expect_parity(look, "environment " + std::to_string(environment));
    look.colored = true, look.material.follows_color = SIDERAY_FOLLOW_DIFFUSE;
    look.model.separate_specular = 1;
    expect_parity(look, "the same with colours, apart " + std::to_string(environment));
  }
}

// The same world with mirrored z, as in left-handed engines (docs/fixed-function.md).
TEST_F(FixedFunction, LeftHandedWorldsLookTheSame) {
  Look look;
  for (const int kind : {0, 1, 2}) look.lights.push_back(random_light(kind));
  numbers.color(look.material.specular, 1), look.material.shininess = 8;
  const GlassHost::Picture right = trace(look);
  is_left_handed = true;
  eye_from_world = glm::scale(eye_from_world, glm::dvec3(1, 1, -1));
  for (Point& p : points) p.place.z = -p.place.z, p.normal.z = -p.normal.z;
  for (sideray_fixed_light& l : look.lights) l.position[2] = -l.position[2], l.spot_direction[2] = -l.spot_direction[2];
  const auto apart = [&](const GlassHost::Picture& left) {
    float most = 0;
    for (int i = 0; i < point_count; ++i)
      for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(left[texel(i)][c] - right[texel(i)][c]));
    return most / code;
  };
  EXPECT_LT(apart(trace(look)), 0.1f);
  keeps_winding = true;
  EXPECT_GT(apart(trace(look)), 10.0f) << "counter-clockwise triangles show their backs there";
}

// glAlphaFunc(GL_GEQUAL, ...) is SIDERAY_MASK: of all 256 alphas rays hit exactly the ones that OpenGL draws.
TEST_F(FixedFunction, AlphaTest) {
  constexpr int side = 16;
  std::vector<uint8_t> texels(size_t{4} * side * side, 255);
  for (size_t i = 0; i < texels.size() / 4; ++i) texels[4 * i + 3] = static_cast<uint8_t>(i);
  const glm::vec2 corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const sideray_texture texture = host.scene().add_texture(side, side, SIDERAY_RGBA8, texels.data());
  for (const GLenum mode : {GLenum{GL_PROJECTION}, GLenum{GL_MODELVIEW}}) gl.MatrixMode(mode), gl.LoadIdentity();
  gl.Enable(GL_ALPHA_TEST);
  for (const int least : {1, 64, 128, 200, 255}) {
    const std::set<int> drawn = drawn_by_alpha(corners, texels, static_cast<float>(least) * code);
    EXPECT_EQ(drawn.size(), size_t{256} - static_cast<size_t>(least));
    EXPECT_EQ(hit_by_alpha(corners, texture, static_cast<float>(least) * code), drawn) << least;
  }
  gl.Disable(GL_ALPHA_TEST);
}

TEST_F(FixedFunction, AllOfItTogether) {
  constexpr uint32_t follows[] = {0, SIDERAY_FOLLOW_AMBIENT, SIDERAY_FOLLOW_DIFFUSE,
                                  SIDERAY_FOLLOW_AMBIENT_AND_DIFFUSE};
  for (int round = 0; round < 12; ++round) {
    Look look;
    for (size_t i = 0; i < most_lights; ++i) look.lights.push_back(random_light((round + static_cast<int>(i)) % 3));
    numbers.color(look.material.ambient, 1), numbers.color(look.material.diffuse, 1),
        numbers.color(look.material.specular, 1);
    numbers.color(look.material.emission, 0.2f);
    look.material.shininess = numbers.in(0.5f, 128);  // drivers differ on 0 to the power of 0
    look.model.local_viewer = round % 2;
    look.model.separate_specular = round % 4 == 3;
    numbers.color(look.model.ambient, 0.3f);
    look.colored = round % 3 != 0, look.material.follows_color = follows[round % 4];
    look.textured = round % 3 != 1;
    look.material.environment = static_cast<sideray_texture_environment>(round / 3 % 4);
    expect_parity(look, "round " + std::to_string(round),
                  look.material.environment == SIDERAY_ENVIRONMENT_ADD ? 0 : 50);
  }
}

}  // namespace
}  // namespace sideray::tests
