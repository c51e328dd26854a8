// Tests sideray_irradiance() in a host's shader: it is the bounced light that the built-in renderer adds, and black
// everywhere else.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <span>
#include <sideray/sideray.hpp>

#include "embed/hosts/wall_host.h"

namespace sideray::tests::snippet_irradiance_test {
namespace {

constexpr float albedo = 0.5f;
using Picture = std::vector<glm::vec4>;

void add_quad(Scene& scene, const sideray_material_desc& material, glm::vec3 center, glm::vec3 u, glm::vec3 v) {
  const glm::vec3 positions[] = {center - u - v, center + u - v, center + u + v, center - u + v};
  const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = &positions[0].x;
  mesh.index_count = 6;
  mesh.indices = indices;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  for (const int i : {0, 4, 8}) instance.world_from_object[i] = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

sideray_material_desc matt(float reflected) {
  sideray_material_desc m = sideray_material_defaults();
  m.double_sided = 1;
  m.metallic = m.specular = 0;
  m.roughness = 1;
  for (float& c : std::span(m.base_color, 3)) c = reflected;
  return m;
}

sideray_material_desc glow() {
  sideray_material_desc m = matt(0);
  for (int c = 0; c < 3; ++c) m.emissive[c] = c == 0 ? 3.0f : 0.5f;
  return m;
}

constexpr float plate_x = -2.4f, plate_half = 3, plate_top = 2;

// Returns a matt wall at z = 0 that fills the picture, and a plate that stands on it, beyond the picture's left edge.
Scene wall_and_plate(const sideray_material_desc& wall, const sideray_material_desc& plate) {
  Scene scene = Scene::create().value();
  add_quad(scene, wall, {0, 0, 0}, {10, 0, 0}, {0, 10, 0});
  add_quad(scene, plate, {plate_x, 0, 0.5f * plate_top}, {0, plate_half, 0}, {0, 0, 0.5f * plate_top});
  const float black[12] = {};
  scene.set_environment(2, 2, black, 1, 0);
  scene.set_lights({});
  scene.commit();
  return scene;
}

// Returns the form factor from a point of the wall to half of the plate, which reaches so far along the wall (Howell, "A
// Catalog of Radiation Heat Transfer Configuration Factors", B-4).
double share_of_half(double distance, double along) {
  const double x = double{plate_top} / along, y = distance / along, a = 1.0 / std::sqrt(x * x + y * y);
  return (std::atan(1.0 / y) - a * y * std::atan(a)) / (2.0 * M_PI);
}

double share_of_plate(double x, double y) {
  const double distance = x - double{plate_x}, half = double{plate_half};
  return share_of_half(distance, half - y) + share_of_half(distance, half + y);
}

class SnippetIrradiance : public WallHost {
 protected:
  SnippetIrradiance() : WallHost(GL_RGBA32F) {
    serve(tracer_);
    program_ = make_program("result = vec4(0.5 * sideray_irradiance(), 1.0);");
  }

  void trace(int x, int y, int w, int h, uint32_t seed = 1) {
    FrameInputs in = frame_of(x, y, w, h);
    in.frame.seed = seed;
    in.irradiance = sideray_irradiance_inputs_defaults();
    in.irradiance->denoise = denoise_;
    WallHost::trace(in);
  }

  // Rows from the bottom.
  Picture draw() {
    const gl::Functions& gl = context_->functions();
    EXPECT_EQ(sideray_service_bind(service_->get(), 0, program_->id(), first_unit, nullptr), SIDERAY_OK);
    program_->use();
    gl.BindVertexArray(array_.id());
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_DEPTH_TEST);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    Picture picture(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  // Compares the light at the wall with that of a plate which is black but for this radiance. The wall must be black.
  void expect_light_of_plate(glm::dvec3 radiance) {
    denoise_ = 0;
    constexpr uint32_t seeds = 64;
    Picture sum(size_t{width} * height);
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
      trace(0, 0, width, height, seed);
      const Picture picture = draw();
      for (size_t i = 0; i < sum.size(); ++i) sum[i] += picture[i] / static_cast<float>(seeds);
    }
    constexpr int border = 8;  // pixels that have light from within the picture alone, which is darker at one side
    glm::dvec3 found(0), expected(0);
    const glm::dmat4 world_from_clip = glm::inverse(clip_from_world());
    for (int y = border; y < height - border; ++y)
      for (int x = border; x < width - border; ++x) {
        found += glm::dvec3(sum[static_cast<size_t>(y * width + x)]);
        const auto on_ray = [&](double depth) {
          const glm::dvec4 p = world_from_clip * glm::dvec4((x + 0.5) / width * 2 - 1, (y + 0.5) / height * 2 - 1, depth, 1);
          return glm::dvec3(p) / p.w;
        };
        const glm::dvec3 a = on_ray(-1), b = on_ray(1), p = a + (b - a) * (a.z / (a.z - b.z));
        expected += 0.5 * radiance * share_of_plate(p.x, p.y);
      }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.02 * expected[c]) << c;
  }

  int32_t denoise_ = 1;
  Scene scene_ = wall_and_plate(matt(albedo), glow());
  Tracer tracer_ = Tracer::create(scene_).value();
};

TEST_F(SnippetIrradiance, IsTheTexturesInItsRectangleAndBlackElsewhere) {
  for (const glm::vec4& texel : draw()) ASSERT_EQ(glm::vec3(texel), glm::vec3(0.0f)) << "before the first frame";
  constexpr int x0 = 8, y0 = 4, w = 72, h = 48;
  trace(x0, y0, w, h);
  sideray_irradiance_outputs outputs{};
  outputs.size = sizeof(outputs);
  ASSERT_EQ(sideray_service_irradiance(service_->get(), 0, &outputs, nullptr), SIDERAY_OK);
  EXPECT_EQ(glm::ivec4(outputs.x, outputs.y, outputs.width, outputs.height), glm::ivec4(x0, y0, w, h));
  Picture texels(size_t{w} * h);
  const gl::Functions& gl = context_->functions();
  gl.BindTexture(GL_TEXTURE_2D, outputs.irradiance_texture);
  gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, texels.data());
  gl.BindTexture(GL_TEXTURE_2D, 0);
  const Picture picture = draw();
  float most = 0.0f;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool inside = x >= x0 && y >= y0 && x < x0 + w && y < y0 + h;
      const glm::vec3 expected = inside ? 0.5f * glm::vec3(texels[static_cast<size_t>((y - y0) * w + x - x0)]) : glm::vec3(0.0f);
      ASSERT_EQ(glm::vec3(picture[static_cast<size_t>(y * width + x)]), expected) << x << ',' << y;
      most = std::max(most, expected.x);
    }
  EXPECT_GT(most, 0.1f);
}

TEST_F(SnippetIrradiance, IsTheLightOfAnEmissiveSurface) {
  scene_ = wall_and_plate(matt(0), glow());
  serve(tracer_ = Tracer::create(scene_).value());
  program_ = make_program("result = vec4(0.5 * sideray_irradiance(), 1.0);");
  expect_light_of_plate({3.0, 0.5, 0.5});
}

// A sun along the wall lights the plate alone.
TEST_F(SnippetIrradiance, IsALampsLightThatAnotherSurfaceReflects) {
  constexpr float reflected = 0.6f, irradiance = 5.0f;
  scene_ = wall_and_plate(matt(0), matt(reflected));
  sideray_light sun = sideray_light_defaults();
  sun.direction[0] = -1, sun.direction[1] = sun.direction[2] = 0;
  for (float& c : sun.intensity) c = irradiance;
  scene_.set_lights({&sun, 1});
  scene_.commit();
  serve(tracer_ = Tracer::create(scene_).value());
  program_ = make_program("result = vec4(0.5 * sideray_irradiance(), 1.0);");
  expect_light_of_plate(glm::dvec3(double{reflected} * double{irradiance} / M_PI));
}

// The wall has no other light, so that the renderer's picture is the irradiance that the shader reads.
TEST_F(SnippetIrradiance, IsWhatTheRendererAdds) {
  trace(0, 0, width, height);
  const Picture by_host = draw();
  context_->release_current();
  sideray_camera camera{};
  camera.size = sizeof(camera);
  for (const int i : {0, 4, 8}) camera.world_from_camera[i] = 1;
  camera.world_from_camera[11] = 3;
  camera.yfov = 0.9f;
  camera.z_near = 0.1f;
  RenderOptions options;
  options.picture.width = width, options.picture.height = height;
  options.picture.ambient = SIDERAY_AMBIENT_BOUNCE;
  options.picture.reflections = 0;
  {
    Renderer renderer = Renderer::create(sideray_renderer_defaults()).value();
    const sideray::Picture picture = renderer.render(scene_, camera, options).value();
    double sum = 0.0, difference = 0.0;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const std::string name = channel.name;
      if (name != "R" && name != "G" && name != "B") continue;
      const int c = name == "R" ? 0 : name == "G" ? 1 : 2;
      const auto* values = static_cast<const float*>(channel.values);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const double host = double{by_host[static_cast<size_t>((height - 1 - y) * width + x)][c]};
          sum += host;
          difference += std::abs(host - double{values[y * width + x]});
        }
    }
    EXPECT_GT(sum, 100.0);
    EXPECT_LT(difference, 0.01 * sum);
  }
  context_->make_current();
}

}  // namespace
}  // namespace sideray::tests::snippet_irradiance_test
