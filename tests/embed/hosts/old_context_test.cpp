// Tests the service in contexts of old versions from the driver itself, and in EGL's default context.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <regex>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "embed/hosts/frame_outputs.h"
#include "embed/hosts/one_pane.h"
#include "gl/resources/objects.h"

namespace sideray::tests::old_context_test {
namespace {

constexpr int width = 64, height = 48;

void* resolve(void*, const char* name) {
  void* const library = dlopen("libEGL.so.1", RTLD_NOW);
  if (!library) return nullptr;
  if (std::strncmp(name, "egl", 3) == 0) return dlsym(library, name);
  const auto get = reinterpret_cast<decltype(&eglGetProcAddress)>(dlsym(library, "eglGetProcAddress"));
  return get ? reinterpret_cast<void*>(get(name)) : nullptr;
}

template <typename F>
F egl(const char* name) {
  return reinterpret_cast<F>(resolve(nullptr, name));
}

// Makes a context current; returns false where there is none.
bool make_context() {
  const auto library_resolve = egl<decltype(&eglGetProcAddress)>("eglGetProcAddress");
  if (!library_resolve) return false;
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(library_resolve("eglGetPlatformDisplayEXT"));
  const EGLDisplay display =
      get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr) : nullptr;
  if (!display || !egl<decltype(&eglInitialize)>("eglInitialize")(display, nullptr, nullptr)) return false;
  if (!egl<decltype(&eglBindAPI)>("eglBindAPI")(EGL_OPENGL_API)) return false;
  const EGLContext context =
      egl<decltype(&eglCreateContext)>("eglCreateContext")(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, nullptr);
  return context && egl<decltype(&eglMakeCurrent)>("eglMakeCurrent")(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
}

FrameInputs inputs(uint32_t framebuffer) {
  FrameInputs in;
  set_matrices(in.frame.view, clip_before_pane(double{width} / height));
  in.frame.source.framebuffer = framebuffer;
  in.frame.source.width = width;
  in.frame.source.height = height;
  in.layers->max_layers = 1;
  return in;
}

// Prints the context's version, and the sum of the distances in its textures.
TEST(OldContextChild, DISABLED_Traces) {
  if (!make_context()) {
    std::printf("none\n");
    return;
  }
  const gl::Functions gl = gl::load_functions(&resolve, nullptr);
  const gl::Renderbuffer depth(gl);
  const gl::Framebuffer framebuffer(gl);
  gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  for (const GLenum attachment : {GL_DEPTH_ATTACHMENT, GL_STENCIL_ATTACHMENT})
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, depth.id());
  gl.DrawBuffer(GL_NONE), gl.ReadBuffer(GL_NONE);
  gl.ClearStencil(1);
  gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  const sideray::Scene scene = pane_scene();
  const sideray::Tracer tracer = sideray::Tracer::create(scene).value();
  const sideray_host_gl host{sizeof(host), &resolve, nullptr};
  const sideray::Service service = sideray::Service::create(tracer, host).value();
  const FrameInputs in = inputs(framebuffer.id());
  sideray_error error{};
  sideray_ticket ticket = 0;
  ASSERT_EQ(submit_frame(service.get(), in, ticket, &error), SIDERAY_OK) << error.message;
  ASSERT_EQ(sideray_service_wait(service.get(), ticket, -1, &error), SIDERAY_OK) << error.message;
  sideray_layer_outputs outputs{};
  outputs.size = sizeof(outputs);
  ASSERT_EQ(sideray_service_layers(service.get(), 0, &outputs, nullptr), SIDERAY_OK);
  std::vector<float> distances(size_t{width} * height);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, outputs.distance_texture);
  gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED, GL_FLOAT, distances.data());
  EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  double sum = 0;
  for (const float d : distances) sum += static_cast<double>(d);
  std::printf("version %d distances %.17g, %s\n", gl.version, sum, gl.version_string.c_str());
}

struct Traced {
  int version = 0;
  double distances = 0;
  std::string output;
};

// Runs this program again, since Mesa reads its environment once.
Traced traced_under(const std::string& environment) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = "exec env " + environment + " '" + program +
                              "' --gtest_also_run_disabled_tests --gtest_filter=OldContextChild.DISABLED_Traces 2>&1";
  Traced traced;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return traced;
  char part[4096];
  for (size_t n = fread(part, 1, sizeof part, pipe); n > 0; n = fread(part, 1, sizeof part, pipe))
    traced.output.append(part, n);
  EXPECT_EQ(pclose(pipe), 0) << traced.output;
  std::smatch match;
  const std::regex result("version (\\d+) distances ([^ ,]+)");
  if (std::regex_search(traced.output, match, result))
    traced.version = std::stoi(match[1]), traced.distances = std::stod(match[2]);
  return traced;
}

TEST(OldContext, OfTheDriverItselfGivesTheSame) {
  const Traced newest = traced_under("SIDERAY_NOTHING=1");
  if (newest.output.find("Mesa") == std::string::npos)
    GTEST_SKIP() << "no surfaceless EGL of Mesa here: " << newest.output;
  EXPECT_GT(newest.distances, 3.0 * 500);
  const std::pair<int, const char*> drivers[] = {
      {21, "MESA_GL_VERSION_OVERRIDE=2.1 'MESA_EXTENSION_OVERRIDE=-GL_ARB_framebuffer_object -GL_ARB_sync'"},
      {21, "MESA_GL_VERSION_OVERRIDE=2.1 GALLIUM_DRIVER=softpipe"},
      {30, "MESA_GL_VERSION_OVERRIDE=3.0"},
      {31, "MESA_GL_VERSION_OVERRIDE=3.1COMPAT MESA_EXTENSION_OVERRIDE=-GL_ARB_sync"}};
  for (const auto& [version, environment] : drivers) {
    const Traced traced = traced_under(environment);
    EXPECT_EQ(traced.version, version) << traced.output;
    EXPECT_EQ(traced.distances, newest.distances) << environment;
  }
}

}  // namespace
}  // namespace sideray::tests::old_context_test
