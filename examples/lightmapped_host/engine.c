#include "engine.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <math.h>
#include <sideray/sideray.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "look.h"

GladGLContext gl;

void require(bool condition, const char* what) {
  if (condition) return;
  fprintf(stderr, "lightmapped_host: %s\n", what);
  exit(1);
}

uint32_t surface_of(int face) {
  return (uint32_t)face + 1;
}

/* ---- Context and programs ---- */

static EGLDisplay open_display(void) {
  const PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
      (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
  require(get_display != NULL, "EGL has no platforms");
  EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
  if (display && eglInitialize(display, NULL, NULL)) return display;
  const PFNEGLQUERYDEVICESEXTPROC query_devices = (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
  EGLDeviceEXT device = NULL;
  EGLint count = 0;
  require(query_devices && query_devices(1, &device, &count) && count > 0, "no EGL device");
  display = get_display(EGL_PLATFORM_DEVICE_EXT, device, NULL);
  require(display && eglInitialize(display, NULL, NULL), "EGL does not start");
  return display;
}

static void create_context(void) {
  const EGLDisplay display = open_display();
  require(eglBindAPI(EGL_OPENGL_API), "no desktop OpenGL");
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, NULL); /* compatibility */
  require(context && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context), "no OpenGL context");
  require(gladLoadGLContext(&gl, (GLADloadfunc)eglGetProcAddress) != 0, "OpenGL entry points are missing");
}

void* get_proc_address(void* user, const char* name) {
  (void)user;
  /* C99 has no cast from a function's address to an object's. */
  const __eglMustCastToProperFunctionPointerType function = eglGetProcAddress(name);
  void* address = NULL;
  memcpy(&address, &function, sizeof(address));
  return address;
}

static GLuint compile(GLenum kind, const char* const* parts, int count) {
  const GLuint shader = gl.CreateShader(kind);
  GLint ok = 0;
  char log[2000] = "";
  gl.ShaderSource(shader, count, parts, NULL);
  gl.CompileShader(shader);
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  gl.GetShaderInfoLog(shader, sizeof(log), NULL, log);
  require(ok, log);
  return shader;
}

/* `snippet`: the text of sideray.glsl, or nothing. */
static GLuint create_program(const char* snippet, const char* main) {
  static const char* const vertex =
      "#version 120\nvarying vec2 uv, light_uv;\nvarying vec3 world;\n"
      "void main() { uv = gl_MultiTexCoord0.xy; light_uv = gl_MultiTexCoord1.xy; world = gl_Vertex.xyz;\n"
      "  gl_Position = gl_ProjectionMatrix * gl_Vertex; }\n";
  const char* const fragment[] = {"#version 120\n", snippet, look_glsl, "uniform float surface, alpha;\n", main};
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, compile(GL_VERTEX_SHADER, &vertex, 1));
  gl.AttachShader(program, compile(GL_FRAGMENT_SHADER, fragment, 5));
  gl.LinkProgram(program);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  require(ok, "a program does not link");
  gl.UseProgram(program);
  gl.Uniform1i(gl.GetUniformLocation(program, "diffuse_map"), 0);
  gl.Uniform1i(gl.GetUniformLocation(program, "light_map"), 1);
  for (int i = 0; i < lamp_count; ++i) {
    char name[32];
    snprintf(name, sizeof(name), "lamp_position[%d]", i);
    gl.Uniform3fv(gl.GetUniformLocation(program, name), 1, lamps[i].position);
    snprintf(name, sizeof(name), "lamp_color[%d]", i);
    gl.Uniform3fv(gl.GetUniformLocation(program, name), 1, lamps[i].color);
  }
  return program;
}

/* ---- Textures, target, camera ---- */

static GLuint create_texture(uint8_t* const* levels, int count, int size, GLint wrap) {
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  for (int level = 0; level < count; ++level)
    gl.TexImage2D(GL_TEXTURE_2D, level, GL_RGBA8, size >> level, size >> level, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                  levels[level]);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, count - 1);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, count > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  return texture;
}

static void create_framebuffer(struct engine* e) {
  GLuint renderbuffers[2] = {0, 0};
  gl.GenFramebuffers(1, &e->framebuffer);
  gl.GenRenderbuffers(2, renderbuffers);
  gl.BindFramebuffer(GL_FRAMEBUFFER, e->framebuffer);
  gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffers[0]);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, e->width, e->height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffers[0]);
  gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffers[1]);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, e->width, e->height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, renderbuffers[1]);
  gl.Viewport(0, 0, e->width, e->height);
}

static void place_camera(struct engine* e) {
  struct camera* c = &e->camera;
  const double z_near = 0.1, z_far = 50.0, yfov = 1.05;
  c->eye[0] = 0.1f, c->eye[1] = 1.45f, c->eye[2] = 4.2f;
  c->half_height = (float)tan(yfov / 2.0);
  c->half_width = c->half_height * (float)e->width / (float)e->height;
  const double x = 1.0 / (double)c->half_width, y = 1.0 / (double)c->half_height;
  const double a = (z_near + z_far) / (z_near - z_far), b = 2.0 * z_near * z_far / (z_near - z_far);
  const double p[3] = {(double)c->eye[0], (double)c->eye[1], (double)c->eye[2]};
  const double forth[16] = {x, 0, 0, 0, 0, y, 0, 0, 0, 0, a, -1, -x * p[0], -y * p[1], b - a * p[2], p[2]};
  const double back[16] = {
      1 / x, 0, 0, 0, 0, 1 / y, 0, 0, p[0] / b, p[1] / b, p[2] / b, 1 / b, a * p[0] / b, a * p[1] / b, a * p[2] / b - 1,
      a / b};
  memcpy(c->clip_from_world, forth, sizeof(forth));
  memcpy(c->world_from_clip, back, sizeof(back));
}

void start_engine(struct engine* e, const struct room* room, int width, int height) {
  memset(e, 0, sizeof(*e));
  e->width = width, e->height = height;
  create_context();
  create_framebuffer(e);
  place_camera(e);
  for (int i = 0; i < texture_count; ++i) {
    const bool glass = i == pane || i == stained;
    e->textures[i] = create_texture(room->textures[i], glass ? 1 : texture_levels, texture_size, GL_REPEAT);
  }
  for (int i = 0; i < face_count; ++i) {
    uint8_t* level = (uint8_t*)room->lightmaps[i];
    e->lightmaps[i] = create_texture(&level, 1, lightmap_size, GL_CLAMP_TO_EDGE);
  }
  e->opaque = create_program("", "void main() { gl_FragColor = vec4(look(), 1.0); }\n");
  e->raster_glass = create_program("", "void main() { gl_FragColor = vec4(look(), alpha); }\n");
  e->glass = create_program(
      sideray_glsl(120), "void main() { gl_FragColor = vec4(sideray_translucent(look(), world, surface), alpha); }\n");
  e->answers = create_program(
      sideray_glsl(120),
      "void main() { gl_FragColor = vec4(sideray_translucent(vec3(1.0, 0.0, 1.0), world, surface), alpha); }\n");
  require(gl.GetError() == GL_NO_ERROR, "an OpenGL error in the engine's set-up");
}

/* ---- Drawing ---- */

static void draw_face(const struct engine* e, const struct room* room, int number) {
  static const float corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const struct face* f = &room->faces[number];
  gl.ActiveTexture(GL_TEXTURE1);
  gl.BindTexture(GL_TEXTURE_2D, e->lightmaps[number]);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, e->textures[f->texture]);
  gl.Begin(GL_TRIANGLE_FAN);
  for (int i = 0; i < 4; ++i) {
    const float s = corners[i][0], t = corners[i][1];
    gl.MultiTexCoord2f(GL_TEXTURE0, s * f->repeats[0], t * f->repeats[1]);
    gl.MultiTexCoord2f(GL_TEXTURE1, s, t);
    gl.Vertex3f(f->corner[0] + s * f->u[0] + t * f->v[0], f->corner[1] + s * f->u[1] + t * f->v[1],
                f->corner[2] + s * f->u[2] + t * f->v[2]);
  }
  gl.End();
}

static void use_program(const struct engine* e, GLuint program) {
  gl.UseProgram(program);
  gl.Uniform3fv(gl.GetUniformLocation(program, "eye"), 1, e->camera.eye);
  gl.MatrixMode(GL_PROJECTION);
  gl.LoadMatrixd(e->camera.clip_from_world);
}

void draw_opaque(const struct engine* e, const struct room* room) {
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  gl.Enable(GL_DEPTH_TEST);
  use_program(e, e->opaque);
  for (int i = 0; i < face_count; ++i) {
    gl.Uniform3fv(gl.GetUniformLocation(e->opaque, "normal"), 1, room->faces[i].normal);
    if (room->faces[i].alpha == 1.0f) draw_face(e, room, i);
  }
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilFunc(GL_NOTEQUAL, 0x3f, 0x3f);
  gl.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  gl.StencilMask(0x3f);
  gl.ColorMask(0, 0, 0, 0);
  gl.DepthMask(0);
  for (int i = 0; i < face_count; ++i)
    if (room->faces[i].alpha < 1.0f) draw_face(e, room, i);
  gl.ColorMask(1, 1, 1, 1);
  gl.DepthMask(1);
  gl.Disable(GL_STENCIL_TEST);
}

static float distance_to(const struct engine* e, const struct face* f) {
  float middle[3];
  for (int c = 0; c < 3; ++c) middle[c] = f->corner[c] + 0.5f * (f->u[c] + f->v[c]) - e->camera.eye[c];
  return dot(middle, middle);
}

/* Returns the farthest glass that is nearer than `limit`; -1 = none. */
static int next_glass(const struct engine* e, const struct room* room, float limit) {
  int farthest = -1;
  for (int i = 0; i < face_count; ++i) {
    if (room->faces[i].alpha == 1.0f || distance_to(e, &room->faces[i]) >= limit) continue;
    if (farthest < 0 || distance_to(e, &room->faces[i]) > distance_to(e, &room->faces[farthest])) farthest = i;
  }
  return farthest;
}

void draw_glass(const struct engine* e, const struct room* room, GLuint program) {
  use_program(e, program);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.DepthMask(0);
  for (int i = next_glass(e, room, 1e30f); i >= 0; i = next_glass(e, room, distance_to(e, &room->faces[i]))) {
    gl.Uniform3fv(gl.GetUniformLocation(program, "normal"), 1, room->faces[i].normal);
    gl.Uniform1f(gl.GetUniformLocation(program, "alpha"), room->faces[i].alpha);
    gl.Uniform1f(gl.GetUniformLocation(program, "surface"), (float)surface_of(i));
    draw_face(e, room, i);
  }
  gl.DepthMask(1);
  gl.Disable(GL_BLEND);
}

uint8_t* read_picture(const struct engine* e) {
  uint8_t* rgb = malloc(3 * (size_t)e->width * (size_t)e->height);
  require(rgb != NULL, "no memory for a picture");
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, e->width, e->height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
  require(gl.GetError() == GL_NO_ERROR, "an OpenGL error in the engine's frame");
  return rgb;
}
