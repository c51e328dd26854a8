#include "engine.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

GladGLContext gl;

const float positions[24] = {-3, 0, -3, 3, 0, -3, 3, 0, 3, -3, 0, 3, -1, 0, 0, 1, 0, 0, 1, 1.5f, 0, -1, 1.5f, 0};
const uint32_t indices[12] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7};

void require(bool condition, const char* what) {
  if (condition) return;
  fprintf(stderr, "minimal_host: %s\n", what);
  exit(1);
}

void check_errors(const char* where) {
  require(gl.GetError() == GL_NO_ERROR, where);
}

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

void create_context(void) {
  const EGLDisplay display = open_display();
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
  require(eglBindAPI(EGL_OPENGL_API), "no desktop OpenGL");
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  require(context && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context), "no OpenGL 3.3 context");
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
  gl.ShaderSource(shader, count, parts, NULL);
  gl.CompileShader(shader);
  GLint ok = 0;
  char log[2000] = "";
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  gl.GetShaderInfoLog(shader, sizeof(log), NULL, log);
  require(ok, log);
  return shader;
}

GLuint create_program(const char* vertex, const char* const* parts, int count) {
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, compile(GL_VERTEX_SHADER, &vertex, 1));
  gl.AttachShader(program, compile(GL_FRAGMENT_SHADER, parts, count));
  gl.LinkProgram(program);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  require(ok, "a program does not link");
  return program;
}

GLuint create_framebuffer(void) {
  GLuint framebuffer = 0, renderbuffers[2] = {0, 0};
  gl.GenFramebuffers(1, &framebuffer);
  gl.GenRenderbuffers(2, renderbuffers);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffers[0]);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA16F, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffers[0]);
  gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffers[1]);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, renderbuffers[1]);
  gl.Viewport(0, 0, width, height);
  return framebuffer;
}

void create_geometry(void) {
  GLuint vertex_array = 0, buffers[2] = {0, 0};
  gl.GenVertexArrays(1, &vertex_array);
  gl.BindVertexArray(vertex_array);
  gl.GenBuffers(2, buffers);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, sizeof(positions), positions, GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof(indices), indices, GL_STATIC_DRAW);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
  gl.EnableVertexAttribArray(0);
}

void look_forward(const double eye[3], double yfov, double clip_from_world[16], double world_from_clip[16]) {
  const double z_near = 0.1, z_far = 100.0;
  const double y = 1.0 / tan(yfov / 2.0), x = y * height / width;
  const double a = (z_near + z_far) / (z_near - z_far), b = 2.0 * z_near * z_far / (z_near - z_far);
  const double forth[16] = {x, 0, 0, 0, 0, y, 0, 0, 0, 0, a, -1, -x * eye[0], -y * eye[1], b - a * eye[2], eye[2]};
  const double back[16] = {1 / x,
                           0,
                           0,
                           0,
                           0,
                           1 / y,
                           0,
                           0,
                           eye[0] / b,
                           eye[1] / b,
                           eye[2] / b,
                           1 / b,
                           a * eye[0] / b,
                           a * eye[1] / b,
                           a * eye[2] / b - 1,
                           a / b};
  memcpy(clip_from_world, forth, sizeof(forth));
  memcpy(world_from_clip, back, sizeof(back));
}
