#include "engine.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstdio>
#include <cstdlib>

GladGLContext gl;

const float positions[] = {-3, 0, -3, 3, 0, -3, 3, 0, 3, -3, 0, 3, -1, 0, 0, 1, 0, 0, 1, 1.5f, 0, -1, 1.5f, 0};
const uint32_t indices[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7};

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "minimal_host: %s\n", what);
  std::exit(1);
}

void check_errors(const char* where) {
  require(gl.GetError() == GL_NO_ERROR, where);
}

void create_context() {
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  EGLDisplay display = get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr) : nullptr;
  if (!display || !eglInitialize(display, nullptr, nullptr)) {
    const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    EGLDeviceEXT device = nullptr;
    EGLint count = 0;
    require(query_devices && query_devices(1, &device, &count) && count > 0, "no EGL device");
    display = get_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
    require(display && eglInitialize(display, nullptr, nullptr), "EGL does not start");
  }
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
  require(eglBindAPI(EGL_OPENGL_API), "no desktop OpenGL");
  EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  require(context && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context), "no OpenGL 3.3 context");
  require(gladLoadGLContext(&gl, eglGetProcAddress) != 0, "OpenGL entry points are missing");
}

void* get_proc_address(void*, const char* name) {
  return reinterpret_cast<void*>(eglGetProcAddress(name));
}

namespace {

GLuint compile(GLenum kind, const std::string& text) {
  const GLuint shader = gl.CreateShader(kind);
  const char* source = text.c_str();
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint ok = 0;
  char log[2000] = "";
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  gl.GetShaderInfoLog(shader, sizeof(log), nullptr, log);
  require(ok, log);
  return shader;
}

}  // namespace

GLuint create_program(const std::string& vertex_text, const std::string& fragment_text) {
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, compile(GL_VERTEX_SHADER, vertex_text));
  gl.AttachShader(program, compile(GL_FRAGMENT_SHADER, fragment_text));
  gl.LinkProgram(program);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  require(ok, "a program does not link");
  return program;
}

GLuint create_framebuffer() {
  GLuint framebuffer = 0, renderbuffers[2] = {};
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

void create_geometry() {
  GLuint vertex_array = 0, buffers[2] = {};
  gl.GenVertexArrays(1, &vertex_array);
  gl.BindVertexArray(vertex_array);
  gl.GenBuffers(2, buffers);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, sizeof(positions), positions, GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof(indices), indices, GL_STATIC_DRAW);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.EnableVertexAttribArray(0);
}
