// Points that the driver's fixed function draws and rays hit, with the same lights, materials, colours and textures.
// Test support.
#pragma once

#include <random>
#include <set>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {

inline constexpr int columns = 24, rows = 16, point_count = columns * rows;
inline constexpr size_t most_lights = 4;
inline constexpr float code = 1.0f / 255;

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

struct Point {
  glm::dvec3 place;
  glm::vec3 normal;
  glm::vec4 color;
};

// Holds the look that is both drawn and traced.
struct Look {
  std::vector<sideray_fixed_light> lights;
  sideray_fixed_material material = sideray_fixed_material_defaults();
  sideray_fixed_function model = sideray_fixed_function_defaults();
  bool unlit = false, textured = false, colored = false;
  float alpha = 1.0f;
  uint8_t texel[4] = {200, 120, 60, 150};
};

inline GLint mode_of(sideray_texture_environment environment) {
  constexpr GLint modes[] = {GL_MODULATE, GL_DECAL, GL_REPLACE, GL_ADD};
  return modes[environment];
}

// Draws points by glBegin, and traces small quads in the same places, with the same lights and materials.
class FixedFunction : public testing::Test {
 protected:
  FixedFunction() : gl(host.gl), depth_(gl), texture_(gl) {
    host.attach(depth_);
    gl.MatrixMode(GL_PROJECTION);
    gl.LoadMatrixd(glm::value_ptr(clip_from_eye));
    gl.MatrixMode(GL_MODELVIEW);
    gl.LoadMatrixd(glm::value_ptr(eye_from_world));
    gl.Enable(GL_NORMALIZE);
    gl.ClampColor(GL_CLAMP_VERTEX_COLOR, GL_TRUE);
    make_points();
  }

  // `kind`: 0 directional, 1 point, 2 spot.
  sideray_fixed_light random_light(int kind) {
    sideray_fixed_light light = sideray_fixed_light_defaults();
    light.casts_shadows = 0;
    numbers.color(light.ambient, 0.3f), numbers.color(light.diffuse, 1), numbers.color(light.specular, 1);
    const glm::vec3 place =
        glm::normalize(numbers.direction() + glm::vec3(0, 0, 1.2f)) * (kind == 0 ? 1.0f : numbers.in(1, 4));
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
  // Returns a light with diffuse and specular terms alone, without attenuation.
  sideray_fixed_light plain_light(int kind) {
    sideray_fixed_light light = random_light(kind);
    for (float& c : light.ambient) c = 0;
    light.constant_attenuation = 1, light.linear_attenuation = light.quadratic_attenuation = 0;
    light.spot_exponent = 0;
    return light;
  }

  void set_light(GLenum name, const sideray_fixed_light& l) const {
    const auto four = [&](GLenum which, const float (&c)[3]) {
      const float value[] = {c[0], c[1], c[2], 1};
      gl.Lightfv(name, which, value);
    };
    gl.Enable(name);
    four(GL_AMBIENT, l.ambient), four(GL_DIFFUSE, l.diffuse), four(GL_SPECULAR, l.specular);
    const float place[] = {static_cast<float>(l.position[0]), static_cast<float>(l.position[1]),
                           static_cast<float>(l.position[2]), static_cast<float>(l.position[3])};
    gl.Lightfv(name, GL_POSITION, place);
    gl.Lightfv(name, GL_SPOT_DIRECTION, l.spot_direction);
    gl.Lightf(name, GL_SPOT_CUTOFF, l.spot_cutoff_deg);
    gl.Lightf(name, GL_SPOT_EXPONENT, l.spot_exponent);
    gl.Lightf(name, GL_CONSTANT_ATTENUATION, l.constant_attenuation);
    gl.Lightf(name, GL_LINEAR_ATTENUATION, l.linear_attenuation);
    gl.Lightf(name, GL_QUADRATIC_ATTENUATION, l.quadratic_attenuation);
  }
  void set_material(const Look& look) const {
    const sideray_fixed_material& m = look.material;
    const auto four = [&](GLenum name, const float (&c)[3]) {
      const float value[] = {c[0], c[1], c[2], name == GL_DIFFUSE ? look.alpha : 1};
      gl.Materialfv(GL_FRONT_AND_BACK, name, value);
    };
    gl.Disable(GL_COLOR_MATERIAL);
    four(GL_AMBIENT, m.ambient), four(GL_DIFFUSE, m.diffuse), four(GL_SPECULAR, m.specular);
    four(GL_EMISSION, m.emission);
    gl.Materialf(GL_FRONT_AND_BACK, GL_SHININESS, m.shininess);
    constexpr GLenum follows[] = {0, GL_AMBIENT, GL_DIFFUSE, GL_AMBIENT_AND_DIFFUSE, GL_SPECULAR, 0, 0, 0, GL_EMISSION};
    if (m.follows_color == 0) return;
    gl.ColorMaterial(GL_FRONT_AND_BACK, follows[m.follows_color]);
    gl.Enable(GL_COLOR_MATERIAL);
  }
  void set_state(const Look& look) const {
    for (size_t i = 0; i < most_lights; ++i) gl.Disable(GL_LIGHT0 + static_cast<GLenum>(i));
    for (size_t i = 0; i < look.lights.size(); ++i) set_light(GL_LIGHT0 + static_cast<GLenum>(i), look.lights[i]);
    set_material(look);
    const float ambient[] = {look.model.ambient[0], look.model.ambient[1], look.model.ambient[2], 1};
    gl.LightModelfv(GL_LIGHT_MODEL_AMBIENT, ambient);
    gl.LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, look.model.local_viewer);
    gl.LightModeli(GL_LIGHT_MODEL_COLOR_CONTROL,
                   look.model.separate_specular ? GL_SEPARATE_SPECULAR_COLOR : GL_SINGLE_COLOR);
    (look.unlit ? gl.Disable : gl.Enable)(GL_LIGHTING);
    (look.textured ? gl.Enable : gl.Disable)(GL_TEXTURE_2D);
    gl.BindTexture(GL_TEXTURE_2D, texture_.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, look.texel);
    gl.TexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, mode_of(look.material.environment));
  }

  // Makes points on a wall before the eye, in the middle of every fourth pixel, with random normals toward the eye.
  void make_points() {
    const glm::dmat4 world = glm::inverse(clip_from_eye * eye_from_world);
    for (int i = 0; i < point_count; ++i) {
      const glm::dvec2 ndc((pixel(i).x + 0.5) / GlassHost::width * 2 - 1,
                           (pixel(i).y + 0.5) / GlassHost::height * 2 - 1);
      const glm::dvec4 at = world * glm::dvec4(ndc, 0.9 + 0.0005 * i / rows, 1);
      Point p{glm::dvec3(at) / at.w, {}, {}};
      const glm::vec3 to_eye(glm::normalize(eye - p.place));
      do p.normal = numbers.direction();
      while (glm::dot(p.normal, to_eye) < 0.05f);
      p.color = {numbers.in(0, 1), numbers.in(0, 1), numbers.in(0, 1), numbers.in(0.2f, 1)};
      points.push_back(p);
    }
  }
  static glm::ivec2 pixel(int i) { return {i % columns * 4 + 1, i / columns * 4 + 2}; }
  static size_t texel(int i) { return static_cast<size_t>(pixel(i).y * GlassHost::width + pixel(i).x); }

  GlassHost::Picture draw(const Look& look) const {
    set_state(look);
    gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
    gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    gl.Begin(GL_POINTS);
    for (const Point& p : points) {
      gl.Normal3f(p.normal.x, p.normal.y, p.normal.z);
      if (look.colored) gl.Color4f(p.color.x, p.color.y, p.color.z, p.color.w);
      else gl.Color4f(1, 1, 1, look.alpha);
      gl.TexCoord2f(0.5f, 0.5f);
      gl.Vertex3d(p.place.x, p.place.y, p.place.z);
    }
    gl.End();
    gl.Disable(GL_TEXTURE_2D);
    GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height);
    gl.ReadPixels(0, 0, GlassHost::width, GlassHost::height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  // Returns small quads around the points, as one mesh.
  sideray_mesh quads(bool colored) {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> colors;
    const glm::mat3 world_from_eye(glm::inverse(eye_from_world));
    for (const Point& p : points)
      for (glm::vec2 corner : {glm::vec2(-1, -1), {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}}) {
        if (is_left_handed && !keeps_winding) std::swap(corner.x, corner.y);  // clockwise ones face front
        positions.push_back(glm::vec3(p.place) + world_from_eye * glm::vec3(0.003f * corner, 0));
        normals.push_back(p.normal);
        colors.push_back(p.color);
      }
    sideray_mesh_desc desc = sideray_mesh_defaults();
    desc.vertex_count = static_cast<uint32_t>(positions.size());
    desc.positions.data = &positions[0].x;
    desc.normals.data = &normals[0].x;
    if (colored) desc.colors.data = &colors[0].x;
    return host.scene().add_mesh(desc);
  }
  void put_in_scene(const Look& look, uint32_t visibility = SIDERAY_VISIBLE_ALL) {
    Scene& scene = host.scene();
    sideray_material_desc desc = sideray_material_defaults();
    desc.alpha_mode = SIDERAY_BLEND;
    desc.blend_mode = SIDERAY_BLEND_PREMULTIPLIED;
    desc.double_sided = 1;
    desc.unlit = look.unlit;
    desc.base_color[3] = look.alpha;
    if (look.textured) {
      desc.base_color_texture.texture = scene.add_texture(1, 1, SIDERAY_RGBA8, look.texel);
      desc.base_color_texture.filter = SIDERAY_NEAREST;
    }
    sideray_instance_desc instance = host.pane_desc();
    instance.mesh = quads(look.colored);
    instance.material = scene.add_material(desc);
    instance.visibility = visibility;
    scene.set_fixed_material(instance.material, look.material);
    scene.remove_instances(std::array{instance_});
    instance_ = scene.add_instances({&instance, 1}).front();
    sideray_fixed_function model = look.model;
    model.lights = look.lights.data(), model.light_count = look.lights.size();
    scene.set_fixed_function(model);
    scene.commit();
  }
  FrameInputs inputs() const {
    FrameInputs in = host.inputs();
    GlassHost::set_view(in, clip_from_eye * eye_from_world);
    in.frame.source.framebuffer = 0, in.frame.source.depth_renderbuffer = depth_.id();
    return in;
  }
  // Traces the points: RGB and coverage.
  GlassHost::Picture trace(const Look& look) {
    put_in_scene(look);
    FrameInputs in = inputs();
    in.layers->mode = SIDERAY_COMPOSITE;
    host.trace(in);
    const sideray_layer_outputs outputs = host.service().layers().value();
    GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height), through = picture;
    gl.BindTexture(GL_TEXTURE_2D, outputs.radiance_texture);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, picture.data());
    gl.BindTexture(GL_TEXTURE_2D, outputs.distance_texture);
    gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, through.data());
    gl.BindTexture(GL_TEXTURE_2D, 0);
    for (size_t i = 0; i < picture.size(); ++i) picture[i].w = 1.0f - through[i].x;
    return picture;
  }

  // Expects drawn and traced points to be equal to 1/255. At least `least` channels must be neither black nor white.
  void expect_parity(const Look& look, const std::string& term, size_t least = size_t{3} * point_count / 10) {
    const GlassHost::Picture drawn = draw(look), traced = trace(look);
    float most = 0;
    size_t telling = 0;
    for (int i = 0; i < point_count; ++i)
      for (int c = 0; c < 4; ++c) {
        const float d = glm::clamp(drawn[texel(i)][c], 0.0f, 1.0f);
        const float off = std::abs(traced[texel(i)][c] - d) / code;
        EXPECT_LT(off, 1.0f) << term << ": point " << i << " channel " << c << " drawn " << d << " traced "
                             << traced[texel(i)][c];
        if (off >= 1.0f) return;
        most = std::max(most, off);
        telling += c < 3 && d > 0.05f && d < 0.98f;
      }
    EXPECT_GE(telling, least) << term << ": most are black or white: nothing is compared";
    std::printf("  %-40s %.2f codes\n", term.c_str(), static_cast<double>(most));
  }

  // Returns which of the 16x16 texels of a square over 16x16 pixels OpenGL draws.
  std::set<int> drawn_by_alpha(const glm::vec2 (&corners)[4], const std::vector<uint8_t>& texels,
                               float reference) const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
    gl.Viewport(0, 0, 16, 16);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    gl.AlphaFunc(GL_GEQUAL, reference);
    gl.Enable(GL_TEXTURE_2D);
    gl.BindTexture(GL_TEXTURE_2D, texture_.id());
    for (const GLenum filter : {GLenum{GL_TEXTURE_MIN_FILTER}, GLenum{GL_TEXTURE_MAG_FILTER}})
      gl.TexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 16, 16, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    gl.Begin(GL_QUADS);
    gl.Color4f(1, 1, 1, 1);
    for (const glm::vec2& c : corners) gl.TexCoord2f(0.5f + 0.5f * c.x, 0.5f + 0.5f * c.y), gl.Vertex3f(c.x, c.y, 0);
    gl.End();
    gl.Disable(GL_TEXTURE_2D);
    std::vector<glm::vec4> pixels(256);
    gl.ReadPixels(0, 0, 16, 16, GL_RGBA, GL_FLOAT, pixels.data());
    std::set<int> drawn;
    for (int i = 0; i < 256; ++i)
      if (pixels[static_cast<size_t>(i)].x > 0) drawn.insert(i);
    return drawn;
  }
  // Returns which texels of that square are hit by a ray through their middle.
  std::set<int> hit_by_alpha(const glm::vec2 (&corners)[4], sideray_texture texture, float cutoff) {
    glm::vec3 positions[4];
    glm::vec2 uvs[4];
    for (size_t i = 0; i < 4; ++i) positions[i] = glm::vec3(corners[i], 40), uvs[i] = 0.5f * corners[i] + 0.5f;
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 4, mesh.index_count = 6, mesh.indices = indices;
    mesh.positions.data = &positions[0].x, mesh.uv0.data = &uvs[0].x;
    sideray_material_desc material = sideray_material_defaults();
    material.alpha_mode = SIDERAY_MASK, material.alpha_cutoff = cutoff, material.double_sided = 1;
    material.base_color_texture.texture = texture, material.base_color_texture.filter = SIDERAY_NEAREST;
    sideray_instance_desc square = host.pane_desc();
    square.mesh = host.scene().add_mesh(mesh), square.material = host.scene().add_material(material);
    square.surface_id = 77, square.visibility = SIDERAY_VISIBLE_ALL;
    const sideray_instance instance = host.scene().add_instances({&square, 1}).front();
    host.scene().commit();
    std::vector<sideray_ray> rays;
    for (int i = 0; i < 256; ++i)
      rays.push_back({{(i % 16 + 0.5) / 8 - 1, (i / 16 + 0.5) / 8 - 1, 41}, {0, 0, -1}, 0, 2});
    const std::vector<sideray_hit> hits = host.tracer().trace(SIDERAY_RAYS_OPAQUE, rays);
    host.scene().remove_instances(std::array{instance});
    std::set<int> hit;
    for (int i = 0; i < 256; ++i)
      if (hits[static_cast<size_t>(i)].surface_id == 77) hit.insert(i);
    return hit;
  }

  GlassHost host{gl::Profile::compatibility};
  const gl::Functions& gl;
  Numbers numbers;
  std::vector<Point> points;
  const glm::dvec3 eye{0.3, 0.2, 3};
  const glm::dmat4 clip_from_eye = glm::perspective(0.9, double{GlassHost::width} / GlassHost::height, 0.1, 50.0);
  glm::dmat4 eye_from_world = glm::lookAt(eye, glm::dvec3(0), glm::dvec3(0, 1, 0));
  bool is_left_handed = false, keeps_winding = false;

 private:
  gl::Renderbuffer depth_;
  gl::Texture texture_;
  sideray_instance instance_ = host.pane();  // replaced by the points
};

}  // namespace sideray::tests
