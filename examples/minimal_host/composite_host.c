/* A host whose glass is drawn by rays alone: it draws opaque surfaces, marks glass in the stencil, and gets one picture
 * of everything translucent, composited along each ray, bent by refraction. Two full-screen passes put it over its own
 * picture. No fragment of glass is shaded, and nothing is matched. Prints the colours seen through the glass, straight
 * and bent; exit code 0 if all went well. */
#include <sideray/sideray.h>
#include <stdio.h>
#include <string.h>

#include "engine.h"
#include "quads.h"

/* Returns a scene of an emissive floor and the front of a block of glass: transmission, a thickness and an index of
 * refraction bend light. */
static sideray_scene* create_scene(void) {
  sideray_scene* scene = NULL;
  sideray_error error;
  sideray_require(sideray_scene_create(&scene, &error), &error);
  sideray_material_desc floor = sideray_material_defaults();
  floor.base_color[0] = floor.base_color[1] = floor.base_color[2] = 0.0f;
  floor.emissive[0] = 0.5f;
  floor.specular = 0.0f;
  floor.double_sided = 1;
  add_quad(scene, 0, &floor, 1);
  sideray_material_desc glass = sideray_material_defaults();
  glass.transmission = 1.0f;
  glass.thickness = 0.2f;
  glass.ior = 1.5f;
  glass.roughness = 0.0f;
  glass.double_sided = 1;
  add_quad(scene, 1, &glass, 2);
  sideray_require(sideray_scene_commit(scene, &error), &error);
  return scene;
}

static GLuint create_floor_program(void) {
  const char* vertex =
      "#version 330 core\nlayout(location = 0) in vec3 position;\nuniform mat4 clip_from_world;\n"
      "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";
  const char* fragment = "#version 330 core\nout vec4 result;\nvoid main() { result = vec4(0.5, 0.0, 0.0, 1.0); }\n";
  return create_program(vertex, &fragment, 1);
}

/* Returns a program that copies a texture of the picture's size, texel by texel. */
static GLuint create_picture_program(void) {
  const char* vertex =
      "#version 330 core\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, "
      "0.0, 1.0); }\n";
  const char* fragment =
      "#version 330 core\nuniform sampler2D picture;\nout vec4 result;\n"
      "void main() { result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0); }\n";
  return create_program(vertex, &fragment, 1);
}

/* Draws opaque surfaces, and sets a stencil bit where a face of glass is in front of them. */
static void draw_opaque_and_mask(GLuint program) {
  gl.UseProgram(program);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  gl.Enable(GL_DEPTH_TEST);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, NULL);
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilFunc(GL_ALWAYS, 1, 1);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  gl.ColorMask(0, 0, 0, 0);
  gl.DepthMask(0);
  gl.DrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_INT, (const void*)(6 * sizeof(uint32_t)));
  gl.ColorMask(1, 1, 1, 1);
  gl.DepthMask(1);
  gl.Disable(GL_STENCIL_TEST);
  gl.Disable(GL_DEPTH_TEST);
}

static void draw_picture(GLuint texture, GLenum source, GLenum destination) {
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.BlendFunc(source, destination);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

/* Computes picture = radiance + picture * transmittance; distance_texture holds the transmittance here. */
static void composite(GLuint program, const sideray_layer_outputs* out) {
  gl.UseProgram(program);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.Enable(GL_BLEND);
  draw_picture(out->distance_texture, GL_ZERO, GL_SRC_COLOR);
  draw_picture(out->radiance_texture, GL_ONE, GL_ONE);
  gl.Disable(GL_BLEND);
  gl.BindTexture(GL_TEXTURE_2D, 0);
}

static void read_pixel(int x, int y, float pixel[4]) {
  gl.ReadPixels(x, y, 1, 1, GL_RGBA, GL_FLOAT, pixel);
}

int main(void) {
  create_context();
  const GLuint framebuffer = create_framebuffer();
  create_geometry();
  const GLuint floor_program = create_floor_program(), picture_program = create_picture_program();
  sideray_error error;
  sideray_scene* scene = create_scene();
  sideray_tracer* tracer = NULL;
  sideray_service* service = NULL;
  const sideray_tracer_desc tracing = sideray_tracer_defaults();
  const sideray_host_gl host = {sizeof(host), get_proc_address, NULL};
  sideray_require(sideray_tracer_create(scene, &tracing, &tracer, &error), &error);
  sideray_require(sideray_service_create(tracer, &host, &service, &error), &error);

  sideray_layer_inputs layers = sideray_layer_inputs_defaults();
  layers.mode = SIDERAY_COMPOSITE;
  layers.max_layers = 0; /* unlimited */
  layers.refraction = 1;
  sideray_frame_inputs frame = sideray_frame_defaults();
  const double eye[3] = {0.0, 0.7, 4.0};
  look_forward(eye, 0.8, frame.view.clip_from_world, frame.view.world_from_clip);
  frame.source.framebuffer = framebuffer;
  frame.source.width = width;
  frame.source.height = height;
  frame.source.mask = SIDERAY_MASK_STENCIL;
  frame.source.stencil_bits = 1;
  frame.layers = &layers;
  float matrix[16];
  for (int i = 0; i < 16; ++i) matrix[i] = (float)frame.view.clip_from_world[i];
  gl.UseProgram(floor_program);
  gl.UniformMatrix4fv(gl.GetUniformLocation(floor_program, "clip_from_world"), 1, GL_FALSE, matrix);

  draw_opaque_and_mask(floor_program);
  const int x = width / 2, low = height / 3, beside = height / 8;
  float straight[4], bent[4], floor_before[4], floor_after[4];
  read_pixel(x, low, straight);
  read_pixel(x, beside, floor_before);
  sideray_ticket ticket = 0;
  sideray_require(sideray_service_submit(service, &frame, &ticket, &error), &error);
  sideray_require(sideray_service_wait(service, ticket, -1, &error), &error);
  sideray_layer_outputs out = {.size = sizeof(out)};
  require(sideray_service_layers(service, 0, &out, &error) == SIDERAY_OK, "no layers after a frame of layers");
  require(out.mode == SIDERAY_COMPOSITE, "the layers are no composite");
  composite(picture_program, &out);
  read_pixel(x, low, bent);
  read_pixel(x, beside, floor_after);
  check_errors("an OpenGL error in the host's frame");

  printf("through the glass: straight %.3f, bent %.3f; beside it %.3f and %.3f\n", (double)straight[0],
         (double)bent[0], (double)floor_before[0], (double)floor_after[0]);
  require(memcmp(floor_before, floor_after, 3 * sizeof(float)) == 0, "a pixel beside the glass has changed");
  /* All light there comes from rays: the host's picture behind the glass must not be added again. */
  require(bent[0] > 0.45f && bent[0] < 0.55f, "the floor is not seen through the glass, once");
  sideray_service_destroy(service);
  sideray_tracer_release(tracer);
  sideray_scene_release(scene);
  return 0;
}
