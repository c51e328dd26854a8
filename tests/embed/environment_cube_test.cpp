// Tests a cube map as environment: in each direction it equals the driver's samplerCube.
#include <gmock/gmock.h>

#include "bridge/api/environment_cube.h"
#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

constexpr uint32_t side = 24;  // its lat-long picture is as wide as the host's

struct Faces {
  std::array<std::vector<float>, 6> texels;
  std::array<const float*, 6> pointers{};

  // Each face has its own colour, in a gradient from corner to corner.
  Faces() {
    for (size_t face = 0; face < 6; ++face) {
      for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
          const float s = (static_cast<float>(x) + 0.5f) / side, t = (static_cast<float>(y) + 0.5f) / side;
          texels[face].insert(texels[face].end(), {static_cast<float>(face) / 6.0f, s, 0.5f * t});
        }
      pointers[face] = texels[face].data();
    }
  }
};

TEST(EnvironmentCube, IsWhatTheDriverReads) {
  GlassHost host;
  const gl::Functions& gl = host.gl;
  const Faces faces;
  const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), 0.7f, glm::normalize(glm::vec3(1, 2, 3))));
  const bridge::LatLong ours = bridge::lat_long_of_cube(side, faces.pointers.data(), &turn[0].x);
  ASSERT_EQ(ours.width, uint32_t{GlassHost::width});
  gl::Texture cube(gl);
  gl.BindTexture(GL_TEXTURE_CUBE_MAP, cube.id());
  gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  for (uint32_t i = 0; i < 6; ++i)
    gl.TexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + i, 0, GL_RGB32F, side, side, 0, GL_RGB, GL_FLOAT, faces.pointers[i]);
  const std::string read =
      "uniform samplerCube cube;\nuniform mat3 turn;\n"
      "vec3 read() {\n"
      "  float azimuth = (gl_FragCoord.x / 96.0 - 0.5) * 6.2831853, polar = (1.0 - gl_FragCoord.y / 48.0) * 3.14159265;\n"
      "  return texture(cube, turn * vec3(sin(polar) * sin(azimuth), cos(polar), -sin(polar) * cos(azimuth))).rgb;\n}\n";
  const gl::Program program = host.program(330, "read()", read);
  program.use();
  gl.UniformMatrix3fv(gl.GetUniformLocation(program.id(), "turn"), 1, GL_FALSE, &turn[0].x);
  // The pane covers the picture.
  const glm::dmat4 close = glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, 0.1));
  const GlassHost::Picture theirs = host.draw(program, 330, close);
  size_t equal = 0;
  for (uint32_t y = 0; y < ours.height; ++y)
    for (uint32_t x = 0; x < ours.width; ++x) {
      const glm::vec4 read_there = theirs[size_t{ours.height - 1 - y} * ours.width + x];
      const float* here = &ours.rgb[3 * (size_t{y} * ours.width + x)];
      float off = 0;
      for (int c = 0; c < 3; ++c) off = std::max(off, std::abs(here[c] - read_there[c]));
      equal += off < 0.02f;
    }
  // Where faces meet, our texel is a mean.
  EXPECT_GT(equal, size_t{ours.width} * ours.height * 85 / 100);
  gl.BindTexture(GL_TEXTURE_CUBE_MAP, 0);
  gl.Disable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
}

TEST(EnvironmentCube, OfOneColourIsThatColour) {
  const std::vector<float> face(3 * 5 * 5, 0.25f);
  const float* faces[6];
  std::fill_n(faces, 6, face.data());
  EXPECT_THAT(bridge::lat_long_of_cube(5, faces, nullptr).rgb, testing::Each(testing::FloatNear(0.25f, 1e-6f)));
}

TEST(EnvironmentCube, BadInputIsNamed) {
  Scene scene = Scene::create().value();
  const std::vector<float> face(3 * 4 * 4, 1.0f);
  const float* faces[6];
  std::fill_n(faces, 6, face.data());
  sideray_error error{};
  const auto set = [&](uint32_t n, const float* turn) {
    return sideray_scene_set_environment_cube(scene.get(), n, faces, 1.0f, turn, &error);
  };
  EXPECT_EQ(set(4, nullptr), SIDERAY_OK);
  EXPECT_EQ(set(0, nullptr), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(set(5000, nullptr), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("4096"));
  const float skewed[9] = {1, 0, 0, 1, 1, 0, 0, 0, 1}, not_a_number[9] = {NAN, 0, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(set(4, skewed), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(set(4, not_a_number), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("cube_from_world"));
  faces[3] = nullptr;
  EXPECT_EQ(set(4, nullptr), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("face 3"));
  scene.commit();
}

}  // namespace
}  // namespace sideray::tests
