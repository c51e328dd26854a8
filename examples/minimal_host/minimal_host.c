/* A host engine: it owns the context, draws an opaque floor, marks the glass in the stencil, asks Sideray for
 * ray-traced shading, and blends the glass with sideray.glsl in its own shader. Any OpenGL error is fatal to it, and it
 * checks that Sideray restores its state. Prints the glass colour by raster and by rays; exit code 0 if all went
 * well. */
#include <sideray/sideray.h>
#include <stdio.h>
#include <string.h>

#include "engine.h"
#include "quads.h"

static const uint32_t glass_id = 7;

/* The host's only change to its glass shader: one include and one line. */
static GLuint create_glass_program(void) {
  const char* vertex =
      "#version 330 core\nlayout(location = 0) in vec3 position;\nuniform mat4 clip_from_world;\nout vec3 world;\n"
      "void main() { world = position; gl_Position = clip_from_world * vec4(position, 1.0); }\n";
  const char* fragment[] = {
      "#version 330 core\n", sideray_glsl(330),
      "in vec3 world;\nuniform vec4 colour;\nuniform uint surface;\nout vec4 result;\n"
      "void main() { result = vec4(sideray_translucent(colour.rgb, world, surface), colour.a); }\n"};
  return create_program(vertex, fragment, 3);
}

static sideray_scene* create_scene(void) {
  sideray_scene* scene = NULL;
  sideray_error error;
  sideray_require(sideray_scene_create(&scene, &error), &error);
  sideray_material_desc floor = sideray_material_defaults();
  floor.base_color[1] = floor.base_color[2] = 0.1f;
  add_quad(scene, 0, &floor, 1);
  sideray_material_desc glass = sideray_material_defaults();
  glass.alpha_mode = SIDERAY_BLEND;
  glass.base_color[3] = 0.5f;
  glass.roughness = 0.05f;
  glass.double_sided = 1;
  add_quad(scene, 1, &glass, glass_id);
  sideray_light sun = sideray_light_defaults();
  sun.direction[1] = -1.0f;
  sun.direction[2] = -0.5f;
  for (int c = 0; c < 3; ++c) sun.intensity[c] = 3.0f;
  sideray_require(sideray_scene_set_lights(scene, &sun, 1, &error), &error);
  sideray_require(sideray_scene_commit(scene, &error), &error);
  return scene;
}

/* State that an engine would cache, and which must not change. */
enum { state_count = 18 };
static void read_state(GLint values[state_count]) {
  static const GLenum names[state_count] = {GL_DRAW_FRAMEBUFFER_BINDING,
                                            GL_READ_FRAMEBUFFER_BINDING,
                                            GL_CURRENT_PROGRAM,
                                            GL_VERTEX_ARRAY_BINDING,
                                            GL_ARRAY_BUFFER_BINDING,
                                            GL_PIXEL_PACK_BUFFER_BINDING,
                                            GL_PIXEL_UNPACK_BUFFER_BINDING,
                                            GL_ACTIVE_TEXTURE,
                                            GL_TEXTURE_BINDING_2D,
                                            GL_TEXTURE_BINDING_2D_ARRAY,
                                            GL_PACK_ALIGNMENT,
                                            GL_UNPACK_ALIGNMENT,
                                            GL_UNPACK_ROW_LENGTH,
                                            GL_BLEND,
                                            GL_DEPTH_TEST,
                                            GL_STENCIL_TEST,
                                            GL_STENCIL_FUNC,
                                            GL_STENCIL_REF};
  for (int i = 0; i < state_count; ++i) gl.GetIntegerv(names[i], &values[i]);
}

static const void* glass_indices(void) {
  return (const void*)(6 * sizeof(uint32_t));
}

static void draw_glass(GLuint program, uint32_t surface) {
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.Uniform4f(gl.GetUniformLocation(program, "colour"), 0.2f, 0.4f, 0.2f, 0.5f);
  gl.Uniform1ui(gl.GetUniformLocation(program, "surface"), surface);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, glass_indices());
  gl.Disable(GL_BLEND);
}

/* Draws the opaque pass, then the mask: the stencil counts the glass surfaces in each pixel. */
static void draw_opaque_and_mask(GLuint program) {
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  gl.Enable(GL_DEPTH_TEST);
  gl.Uniform4f(gl.GetUniformLocation(program, "colour"), 0.5f, 0.05f, 0.05f, 1.0f);
  gl.Uniform1ui(gl.GetUniformLocation(program, "surface"), 0);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, NULL);
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilMask(0x3f);
  gl.StencilFunc(GL_NOTEQUAL, 0x3f, 0x3f);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  gl.ColorMask(0, 0, 0, 0);
  gl.DepthMask(0);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, glass_indices());
  gl.ColorMask(1, 1, 1, 1);
  gl.Disable(GL_STENCIL_TEST);
}

/* Draws a frame, and reads the glass colour in the middle of the picture. */
static void draw_frame(GLuint program, sideray_service* service, const sideray_frame_inputs* inputs, bool by_rays,
                       float pixel[4]) {
  sideray_error error;
  sideray_ticket ticket = 0;
  GLint before[state_count], after[state_count];
  draw_opaque_and_mask(program);
  check_errors("an OpenGL error in the host's opaque pass");
  read_state(before);
  sideray_require(sideray_service_submit(service, inputs, &ticket, &error), &error);
  sideray_require(sideray_service_wait(service, ticket, -1, &error), &error);
  check_errors("Sideray left an OpenGL error");
  read_state(after);
  require(memcmp(before, after, sizeof(before)) == 0, "Sideray changed the host's state");
  sideray_require(sideray_service_bind(service, 0, program, 0, &error), &error);
  draw_glass(program, by_rays ? glass_id : 0);
  gl.DepthMask(1);
  check_errors("an OpenGL error in the host's glass pass");
  gl.ReadPixels(width / 2, height / 2, 1, 1, GL_RGBA, GL_FLOAT, pixel);
}

static void set_camera(GLuint program, sideray_view* view) {
  const double eye[3] = {0.0, 0.7, 4.0};
  float matrix[16];
  memset(view, 0, sizeof(*view));
  look_forward(eye, 0.8, view->clip_from_world, view->world_from_clip);
  for (int i = 0; i < 16; ++i) matrix[i] = (float)view->clip_from_world[i];
  gl.UseProgram(program);
  gl.UniformMatrix4fv(gl.GetUniformLocation(program, "clip_from_world"), 1, 0, matrix);
}

int main(void) {
  create_context();
  sideray_layer_inputs layers = sideray_layer_inputs_defaults();
  layers.max_layers = 2;
  sideray_frame_inputs inputs = sideray_frame_defaults();
  inputs.source.framebuffer = create_framebuffer();
  inputs.source.width = width;
  inputs.source.height = height;
  inputs.layers = &layers;
  create_geometry();
  const GLuint program = create_glass_program();
  set_camera(program, &inputs.view);
  check_errors("an OpenGL error in the host's set-up");

  sideray_error error;
  sideray_scene* scene = create_scene();
  sideray_tracer* tracer = NULL;
  sideray_service* service = NULL;
  const sideray_tracer_desc tracing = sideray_tracer_defaults();
  const sideray_host_gl host = {sizeof(host), get_proc_address, NULL};
  sideray_require(sideray_tracer_create(scene, &tracing, &tracer, &error), &error);
  sideray_require(sideray_service_create(tracer, &host, &service, &error), &error);
  float raster[4], rays[4];
  for (int frame = 0; frame < 3; ++frame) {
    draw_frame(program, service, &inputs, false, raster);
    draw_frame(program, service, &inputs, true, rays);
  }
  sideray_service_destroy(service);
  sideray_tracer_release(tracer);
  sideray_scene_release(scene);
  printf("glass by raster %.4f %.4f %.4f, by rays %.4f %.4f %.4f\n", raster[0], raster[1], raster[2], rays[0], rays[1],
         rays[2]);
  require(memcmp(raster, rays, sizeof(raster)) != 0, "the glass did not take its ray-traced colour");
  return 0;
}
