// A host engine: it owns the context, draws an opaque floor, marks the glass in stencil, asks Sideray for
// ray-traced shading, and blends the glass with sideray.glsl in its own shader. Any OpenGL error is fatal to it, and it
// checks that Sideray puts its state back. Prints the glass colour by raster and by rays; exit code 0 if all went well.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "engine.h"

namespace {

constexpr uint32_t glass_id = 7;

// The host's only change to its glass shader: one include and one line.
GLuint create_glass_program() {
  const std::string vertex =
      "#version 330 core\nlayout(location = 0) in vec3 position;\nuniform mat4 clip_from_world;\nout vec3 world;\n"
      "void main() { world = position; gl_Position = clip_from_world * vec4(position, 1.0); }\n";
  const std::string fragment =
      std::string("#version 330 core\n") + sideray_glsl(330) +
      "in vec3 world;\nuniform vec4 colour;\nuniform uint surface;\nout vec4 result;\n"
      "void main() { result = vec4(sideray_translucent(colour.rgb, world, surface), colour.a); }\n";
  return create_program(vertex, fragment);
}

void add_quad(sideray::Scene& scene, int first_vertex, const sideray_material_desc& material, uint32_t surface_id) {
  static const uint32_t quad[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = positions + 3 * first_vertex;
  mesh.index_count = 6;
  mesh.indices = quad[first_vertex / 4];
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  for (int i : {0, 4, 8}) instance.world_from_object[i] = 1.0;
  instance.surface_id = surface_id;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

sideray::Scene create_scene() {
  sideray::Scene scene = sideray::Scene::create().value();
  sideray_material_desc floor = sideray_material_defaults();
  floor.base_color[1] = floor.base_color[2] = 0.1f;
  add_quad(scene, 0, floor, 1);
  sideray_material_desc glass = sideray_material_defaults();
  glass.alpha_mode = SIDERAY_BLEND;
  glass.base_color[3] = 0.5f;
  glass.roughness = 0.05f;
  glass.double_sided = 1;
  add_quad(scene, 4, glass, glass_id);
  sideray_light sun{};
  sun.size = sizeof(sun);
  sun.direction[1] = -1.0f;
  sun.direction[2] = -0.5f;
  for (float& c : sun.intensity) c = 3.0f;
  scene.set_lights({&sun, 1});
  scene.commit();
  return scene;
}

sideray_view create_view(glm::dmat4& clip_from_world) {
  clip_from_world = glm::perspective(0.8, double{width} / height, 0.1, 100.0) *
                    glm::lookAt(glm::dvec3(0, 1.2, 4), glm::dvec3(0, 0.6, 0), glm::dvec3(0, 1, 0));
  sideray_view view{};
  view.size = sizeof(view);
  std::memcpy(view.clip_from_world, glm::value_ptr(clip_from_world), sizeof(view.clip_from_world));
  const glm::dmat4 world_from_clip = glm::inverse(clip_from_world);
  std::memcpy(view.world_from_clip, glm::value_ptr(world_from_clip), sizeof(view.world_from_clip));
  return view;
}

// State that an engine would have cached and must find unchanged.
std::vector<GLint> state() {
  std::vector<GLint> values;
  for (const GLenum name :
       {GL_DRAW_FRAMEBUFFER_BINDING, GL_READ_FRAMEBUFFER_BINDING, GL_CURRENT_PROGRAM, GL_VERTEX_ARRAY_BINDING,
        GL_ARRAY_BUFFER_BINDING, GL_PIXEL_PACK_BUFFER_BINDING, GL_PIXEL_UNPACK_BUFFER_BINDING, GL_ACTIVE_TEXTURE,
        GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_2D_ARRAY, GL_PACK_ALIGNMENT, GL_UNPACK_ALIGNMENT,
        GL_UNPACK_ROW_LENGTH, GL_BLEND, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_STENCIL_FUNC, GL_STENCIL_REF}) {
    GLint value = 0;
    gl.GetIntegerv(name, &value);
    values.push_back(value);
  }
  return values;
}

void draw_glass(GLuint program, uint32_t surface) {
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.Uniform4f(gl.GetUniformLocation(program, "colour"), 0.2f, 0.4f, 0.2f, 0.5f);
  gl.Uniform1ui(gl.GetUniformLocation(program, "surface"), surface);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, reinterpret_cast<void*>(6 * sizeof(uint32_t)));
  gl.Disable(GL_BLEND);
}

std::vector<float> glass_pixel() {
  std::vector<float> pixel(4);
  gl.ReadPixels(width / 2, height / 2, 1, 1, GL_RGBA, GL_FLOAT, pixel.data());
  return pixel;
}

// The opaque pass, then the mask: stencil counts the glass surfaces in each pixel.
void draw_opaque_and_mask(GLuint program) {
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  gl.Enable(GL_DEPTH_TEST);
  gl.Uniform4f(gl.GetUniformLocation(program, "colour"), 0.5f, 0.05f, 0.05f, 1.0f);
  gl.Uniform1ui(gl.GetUniformLocation(program, "surface"), 0);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, nullptr);
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilMask(0x3f);
  gl.StencilFunc(GL_NOTEQUAL, 0x3f, 0x3f);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  gl.ColorMask(0, 0, 0, 0);
  gl.DepthMask(0);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, reinterpret_cast<void*>(6 * sizeof(uint32_t)));
  gl.ColorMask(1, 1, 1, 1);
  gl.Disable(GL_STENCIL_TEST);
}

std::vector<float> draw_frame(GLuint program, GLuint framebuffer, sideray::Service& service, const sideray_view& view,
                              bool by_rays) {
  draw_opaque_and_mask(program);
  check_errors("an OpenGL error in the host's opaque pass");
  const std::vector<GLint> before = state();
  sideray_frame_inputs inputs = sideray_frame_defaults();
  inputs.view = view;
  inputs.framebuffer = framebuffer;
  inputs.width = width;
  inputs.height = height;
  inputs.max_layers = 2;
  sideray_ticket ticket = 0;
  sideray::check([&](sideray_error* e) { return sideray_service_submit(service.get(), &inputs, &ticket, e); });
  sideray::check([&](sideray_error* e) { return sideray_service_wait(service.get(), ticket, -1, e); });
  check_errors("Sideray left an OpenGL error");
  require(state() == before, "Sideray changed the host's state");
  sideray::check([&](sideray_error* e) { return sideray_service_bind(service.get(), program, 0, e); });
  draw_glass(program, by_rays ? glass_id : 0);
  gl.DepthMask(1);
  check_errors("an OpenGL error in the host's glass pass");
  return glass_pixel();
}

}  // namespace

int main() try {
  create_context();
  const GLuint framebuffer = create_framebuffer();
  create_geometry();
  const GLuint program = create_glass_program();
  glm::dmat4 clip_from_world;
  const sideray_view view = create_view(clip_from_world);
  gl.UseProgram(program);
  gl.UniformMatrix4fv(gl.GetUniformLocation(program, "clip_from_world"), 1, 0,
                      glm::value_ptr(glm::mat4(clip_from_world)));
  check_errors("an OpenGL error in the host's set-up");

  sideray::Scene scene = create_scene();
  sideray::Tracer tracer = sideray::Tracer::create(scene).value();
  const sideray_host_gl host{sizeof(sideray_host_gl), get_proc_address, nullptr};
  sideray::Service service = sideray::Service::create(tracer, host).value();
  std::vector<float> raster, rays;
  for (int frame = 0; frame < 3; ++frame) {
    raster = draw_frame(program, framebuffer, service, view, false);
    rays = draw_frame(program, framebuffer, service, view, true);
  }
  std::printf("glass by raster %.4f %.4f %.4f, by rays %.4f %.4f %.4f\n", double{raster[0]}, double{raster[1]},
              double{raster[2]}, double{rays[0]}, double{rays[1]}, double{rays[2]});
  require(raster != rays, "the glass did not take its ray-traced colour");
} catch (const std::exception& error) {
  std::fprintf(stderr, "minimal_host: %s\n", error.what());
  return 1;
}
