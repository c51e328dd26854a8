// sideray_ready_shade against what the driver's fixed function makes of the same lights, materials and points; and what
// it gives to rays.
#include <gmock/gmock.h>
#include <sideray/ready_shade.h>

#include <random>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

constexpr int columns = 24, rows = 16, light_count = 4;

struct Numbers {
  std::mt19937 engine{7};
  float in(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); }
  void color(float (&c)[3], float most) {
    for (float& x : c) x = in(0, most);
  }
  glm::vec3 direction() {
    for (;;) {
      const glm::vec3 v(in(-1, 1), in(-1, 1), in(-1, 1));
      if (glm::length(v) > 0.1f && glm::length(v) < 1.0f) return glm::normalize(v);
    }
  }
};

// Lights, materials and points by chance, drawn as single points by glBegin and shaded by the function.
class FixedFunction : public testing::Test {
 protected:
  FixedFunction() : gl(host.gl) {
    gl.MatrixMode(GL_PROJECTION);
    gl.LoadMatrixd(glm::value_ptr(clip_from_eye));
    gl.MatrixMode(GL_MODELVIEW);
    gl.LoadMatrixd(glm::value_ptr(eye_from_world));
    gl.Enable(GL_LIGHTING);
    gl.Enable(GL_NORMALIZE);
    gl.ClampColor(GL_CLAMP_VERTEX_COLOR, GL_TRUE);
  }

  sideray_fixed_light random_light(int kind) {
    sideray_fixed_light light = sideray_fixed_light_defaults();
    numbers.color(light.ambient, 0.3f), numbers.color(light.diffuse, 1), numbers.color(light.specular, 1);
    const glm::vec3 place = numbers.direction() * (kind == 0 ? 1.0f : numbers.in(1, 4));
    light.position[3] = kind == 0 ? 0.0 : static_cast<double>(numbers.in(0.3f, 3));
    const double scale = kind == 0 ? 1.0 : light.position[3];
    for (int c = 0; c < 3; ++c) light.position[c] = scale * static_cast<double>(place[c]);
    light.constant_attenuation = numbers.in(0.3f, 1);
    light.linear_attenuation = numbers.in(0, 0.5f), light.quadratic_attenuation = numbers.in(0, 0.3f);
    if (kind < 2) return light;
    const glm::vec3 axis = -place * numbers.in(0.5f, 2) + 0.3f * numbers.direction();
    for (int c = 0; c < 3; ++c) light.spot_direction[c] = axis[c];
    light.spot_cutoff_deg = numbers.in(10, 90), light.spot_exponent = numbers.in(0, 40);
    return light;
  }

  void set_light(int i, const sideray_fixed_light& l) const {
    const auto four = [&](GLenum name, const float (&c)[3]) {
      const float value[] = {c[0], c[1], c[2], 1};
      gl.Lightfv(GL_LIGHT0 + i, name, value);
    };
    gl.Enable(GL_LIGHT0 + i);
    four(GL_AMBIENT, l.ambient), four(GL_DIFFUSE, l.diffuse), four(GL_SPECULAR, l.specular);
    const float place[] = {static_cast<float>(l.position[0]), static_cast<float>(l.position[1]),
                           static_cast<float>(l.position[2]), static_cast<float>(l.position[3])};
    gl.Lightfv(GL_LIGHT0 + i, GL_POSITION, place);
    gl.Lightfv(GL_LIGHT0 + i, GL_SPOT_DIRECTION, l.spot_direction);
    gl.Lightf(GL_LIGHT0 + i, GL_SPOT_CUTOFF, l.spot_cutoff_deg);
    gl.Lightf(GL_LIGHT0 + i, GL_SPOT_EXPONENT, l.spot_exponent);
    gl.Lightf(GL_LIGHT0 + i, GL_CONSTANT_ATTENUATION, l.constant_attenuation);
    gl.Lightf(GL_LIGHT0 + i, GL_LINEAR_ATTENUATION, l.linear_attenuation);
    gl.Lightf(GL_LIGHT0 + i, GL_QUADRATIC_ATTENUATION, l.quadratic_attenuation);
  }
  void set_material(const sideray_fixed_material& m) const {
    const auto four = [&](GLenum name, const float (&c)[3]) {
      const float value[] = {c[0], c[1], c[2], 1};
      gl.Materialfv(GL_FRONT_AND_BACK, name, value);
    };
    four(GL_AMBIENT, m.ambient), four(GL_DIFFUSE, m.diffuse), four(GL_SPECULAR, m.specular);
    four(GL_EMISSION, m.emission);
    gl.Materialf(GL_FRONT_AND_BACK, GL_SHININESS, m.shininess);
  }
  void set_model(const sideray_fixed_function& look) const {
    const float ambient[] = {look.ambient[0], look.ambient[1], look.ambient[2], 1};
    gl.LightModelfv(GL_LIGHT_MODEL_AMBIENT, ambient);
    gl.LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, look.local_viewer);
    gl.LightModeli(GL_LIGHT_MODEL_COLOR_CONTROL, look.separate_specular ? GL_SEPARATE_SPECULAR_COLOR : GL_SINGLE_COLOR);
  }

  // Points of a wall before the eye, one in the middle of each fourth pixel, with normals by chance.
  std::vector<sideray_shading_point> random_points() {
    std::vector<sideray_shading_point> points(size_t{columns} * rows);
    const glm::dmat4 world = glm::inverse(clip_from_eye * eye_from_world);
    for (int i = 0; i < columns * rows; ++i) {
      sideray_shading_point& p = points[static_cast<size_t>(i)];
      const glm::dvec2 ndc((pixel(i).x + 0.5) / GlassHost::width * 2 - 1, (pixel(i).y + 0.5) / GlassHost::height * 2 - 1);
      const glm::dvec4 at = world * glm::dvec4(ndc, 0.9 + 0.0005 * i / rows, 1);
      const glm::dvec3 place = glm::dvec3(at) / at.w, to_eye = glm::normalize(eye - place);
      const glm::vec3 normal = numbers.direction();
      for (int c = 0; c < 3; ++c) {
        p.position[c] = place[c], p.to_eye[c] = static_cast<float>(to_eye[c]), p.normal[c] = normal[c];
        p.base_color[c] = 1;
      }
      p.front = 1, p.lights = ~0u;
    }
    return points;
  }
  static glm::ivec2 pixel(int i) { return {i % columns * 4 + 1, i / columns * 4 + 2}; }

  GlassHost::Picture draw(const std::vector<sideray_shading_point>& points) const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
    gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    gl.Begin(GL_POINTS);
    for (const sideray_shading_point& p : points) {
      gl.Normal3fv(p.normal);
      gl.Vertex3dv(p.position);
    }
    gl.End();
    GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height);
    gl.ReadPixels(0, 0, GlassHost::width, GlassHost::height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  GlassHost host{gl::Profile::compatibility};
  const gl::Functions& gl;
  Numbers numbers;
  const glm::dvec3 eye{0.3, 0.2, 3};
  const glm::dmat4 clip_from_eye = glm::perspective(0.9, double{GlassHost::width} / GlassHost::height, 0.1, 50.0);
  const glm::dmat4 eye_from_world = glm::lookAt(eye, glm::dvec3(0), glm::dvec3(0, 1, 0));
};

TEST_F(FixedFunction, IsWhatTheDriverMakesOfLightsAndMaterials) {
  size_t lit = 0, compared = 0;
  for (int round = 0; round < 12; ++round) {
    sideray_fixed_light lights[light_count];
    for (int i = 0; i < light_count; ++i) set_light(i, lights[i] = random_light((round + i) % 3));
    sideray_fixed_material material = sideray_fixed_material_defaults();
    numbers.color(material.ambient, 1), numbers.color(material.diffuse, 1), numbers.color(material.specular, 1);
    numbers.color(material.emission, 0.2f);
    material.shininess = numbers.in(0.5f, 128);  // drivers differ on 0 to the power of 0
    set_material(material);
    sideray_fixed_function look = sideray_fixed_function_defaults();
    look.lights = lights, look.light_count = light_count;
    look.materials = &material, look.material_count = 1;
    look.local_viewer = round % 2;
    look.separate_specular = round % 4 == 3;
    const glm::dvec3 back = glm::dvec3(glm::inverse(eye_from_world) * glm::dvec4(0, 0, 1, 0));
    for (int c = 0; c < 3; ++c) look.viewer[c] = static_cast<float>(back[c]);
    numbers.color(look.ambient, 0.3f);
    set_model(look);
    const std::vector<sideray_shading_point> points = random_points();
    std::vector<sideray_shading_result> results(points.size());
    const GlassHost::Picture picture = draw(points);
    sideray_ready_shade(&look, points.data(), points.size(), results.data());
    for (int i = 0; i < columns * rows; ++i) {
      const glm::vec4 drawn = picture[static_cast<size_t>(pixel(i).y * GlassHost::width + pixel(i).x)];
      ASSERT_GT(drawn.w, 0) << i;
      for (int c = 0; c < 3; ++c) {
        const float ours = results[static_cast<size_t>(i)].radiance[c];
        EXPECT_NEAR(ours, std::min(drawn[c], 1.0f), 0.5f / 255) << "round " << round << " point " << i << " channel " << c;
        lit += ours > 0.2f && ours < 0.98f, ++compared;
      }
    }
  }
  EXPECT_GT(lit * 3, compared) << "most are black or white: nothing is compared";
}

TEST_F(FixedFunction, ShadowsTakeDirectLightAlone) {
  sideray_fixed_light light = sideray_fixed_light_defaults();
  for (int c = 0; c < 3; ++c) light.diffuse[c] = 0.5f, light.ambient[c] = 0.25f;
  light.shadow = 3;
  sideray_fixed_material material = sideray_fixed_material_defaults();
  for (int c = 0; c < 3; ++c) material.diffuse[c] = material.ambient[c] = 1;
  sideray_fixed_function look = sideray_fixed_function_defaults();
  look.lights = &light, look.light_count = 1, look.materials = &material, look.material_count = 1;
  for (float& c : look.ambient) c = 0;
  sideray_shading_point point{};
  point.normal[2] = point.to_eye[2] = 1, point.front = 1;
  for (float& c : point.base_color) c = 1;
  sideray_shading_result result{};
  point.lights = 1u << 3;
  sideray_ready_shade(&look, &point, 1, &result);
  EXPECT_FLOAT_EQ(result.radiance[0], 0.75f);
  point.lights = ~(1u << 3);
  sideray_ready_shade(&look, &point, 1, &result);
  EXPECT_FLOAT_EQ(result.radiance[0], 0.25f);
  light.shadow = -1;
  sideray_ready_shade(&look, &point, 1, &result);
  EXPECT_FLOAT_EQ(result.radiance[0], 0.75f);
  point.front = 0;  // its one side looks away
  sideray_ready_shade(&look, &point, 1, &result);
  EXPECT_FLOAT_EQ(result.radiance[0], 0.25f);
  look.two_sided = 1;
  sideray_ready_shade(&look, &point, 1, &result);
  EXPECT_FLOAT_EQ(result.radiance[0], 0.75f);
}

// A host that blends what is shown gives its glass a reflectance; the test looks at what light would have made of it.
class GammaReflections : public FixedFunction {
 protected:
  // What the pane adds to the picture, of an environment that is shown as `mirrored`.
  float added(float reflectance, float mirrored) {
    for (float& c : material_.reflectance) c = reflectance;
    const std::vector<float> sky(3 * 2 * 2, std::pow(mirrored, 2.2f));
    host.scene().set_environment(2, 2, sky.data(), 1.0f, 0.0f);
    host.scene().set_shader(shader_);
    host.scene().commit();
    FrameInputs in = host.inputs();
    in.frame.source.depth_renderbuffer = depth_.id();
    host.trace(in);
    return host.draw(program_, 330)[size_t{GlassHost::height / 2} * GlassHost::width + GlassHost::width / 2].x;
  }
  // Root of the mean square of what the host shows less what light makes, over all brightnesses.
  double error(float share, float reflectance) {
    double sum = 0;
    int count = 0;
    for (const float mirrored : {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
      const double adds = static_cast<double>(added(reflectance, mirrored));
      EXPECT_NEAR(adds, static_cast<double>(reflectance * mirrored), 0.002) << "the mirrored picture is mixed as it is shown";
      for (double behind = 0; behind <= 1; behind += 0.05, ++count) {
        const double light = (1 - static_cast<double>(share)) * std::pow(behind, 2.2) + static_cast<double>(share) * std::pow(static_cast<double>(mirrored), 2.2);
        const double off = (1 - static_cast<double>(reflectance)) * behind + adds - std::pow(light, 1 / 2.2);
        sum += off * off;
      }
    }
    return std::sqrt(sum / count);
  }

  void SetUp() override {
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, cleared_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.DrawBuffer(GL_NONE);
    gl.ClearDepth(1.0);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    for (int c = 0; c < 3; ++c) material_.ambient[c] = 0;
    look_.materials = &material_, look_.material_count = 1;
    shader_.shade = sideray_ready_shade, shader_.user = &look_;
    shader_.radiance_space = SIDERAY_SPACE_GAMMA22;
  }

 private:
  gl::Renderbuffer depth_{gl};
  gl::Framebuffer cleared_{gl};
  sideray_fixed_material material_ = sideray_fixed_material_defaults();
  sideray_fixed_function look_ = sideray_fixed_function_defaults();
  sideray_shader_desc shader_ = sideray_shader_defaults();
  gl::Program program_ = host.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)");
};

TEST_F(GammaReflections, AreNearestWithTheTrueReflectance) {
  for (const float share : {0.04f, 0.08f}) {
    const double root = error(share, std::pow(share, 1 / 2.2f)), true_share = error(share, share),
                 best = error(share, std::pow(share, 0.8f));
    EXPECT_GT(root, 1.7 * true_share) << "the root is for glass before black";
    EXPECT_LT(best, true_share);
  }
}

// By rays: the pane of a frame shows what the function says of it.
TEST_F(FixedFunction, IsWhatRaysShow) {
  sideray_fixed_material material = sideray_fixed_material_defaults();
  for (int c = 0; c < 3; ++c) material.emission[c] = 0.125f * static_cast<float>(c + 1), material.ambient[c] = 0;
  sideray_fixed_function look = sideray_fixed_function_defaults();
  look.materials = &material, look.material_count = 1;
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = sideray_ready_shade, shader.user = &look;
  shader.radiance_space = SIDERAY_SPACE_GAMMA22;
  host.scene().set_shader(shader);
  host.scene().commit();
  gl::Renderbuffer depth(gl);
  gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
  gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  host.trace(host.inputs());
  const GlassHost::Picture picture = host.draw(host.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)"), 330);
  const glm::vec4 middle = picture[size_t{GlassHost::height / 2} * GlassHost::width + GlassHost::width / 2];
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], material.emission[c], 1.0f / 1024);
}

}  // namespace
}  // namespace sideray::tests
