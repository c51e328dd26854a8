// Tests that the snippet compiles in OpenGL ES 3.00, where the service itself does not run.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sideray/sideray.h>

#include <cstdlib>
#include <string>

namespace sideray::tests::snippet_es_test {
namespace {

// EGL by name, as everywhere: nothing here links it.
struct Egl {
  void* library = dlopen("libEGL.so.1", RTLD_NOW);
  template <typename F>
  F get(const char* name) const {
    const auto resolve =
        library ? reinterpret_cast<decltype(&eglGetProcAddress)>(dlsym(library, "eglGetProcAddress")) : nullptr;
    return resolve ? reinterpret_cast<F>(resolve(name)) : nullptr;
  }
};

class EsContext {
 public:
  EsContext() {
    const auto get_display = egl.get<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const auto devices = egl.get<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    EGLDeviceEXT list[8] = {};
    EGLint count = 0;
    if (!get_display || !devices || !devices(8, list, &count)) return;
    for (EGLint i = 0; i < count && !context; ++i) open(get_display(EGL_PLATFORM_DEVICE_EXT, list[i], nullptr));
  }
  ~EsContext() {
    if (!context) return;
    egl.get<decltype(&eglMakeCurrent)>("eglMakeCurrent")(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl.get<decltype(&eglDestroyContext)>("eglDestroyContext")(display, context);
  }
  EsContext(const EsContext&) = delete;
  EsContext& operator=(const EsContext&) = delete;

  // 320: OpenGL ES 3.2.
  int version() const {
    GLint major = 0, minor = 0;
    const auto get = egl.get<void (*)(GLenum, GLint*)>("glGetIntegerv");
    get(GL_MAJOR_VERSION, &major), get(GL_MINOR_VERSION, &minor);
    return 100 * major + 10 * minor;
  }

  // Returns the compiler's message; "" if it accepts the shader.
  std::string complaint(const std::string& fragment) const {
    const auto create = egl.get<PFNGLCREATESHADERPROC>("glCreateShader");
    const auto source = egl.get<PFNGLSHADERSOURCEPROC>("glShaderSource");
    const auto compile = egl.get<PFNGLCOMPILESHADERPROC>("glCompileShader");
    const auto status = egl.get<PFNGLGETSHADERIVPROC>("glGetShaderiv");
    const auto log = egl.get<PFNGLGETSHADERINFOLOGPROC>("glGetShaderInfoLog");
    const GLuint shader = create(GL_FRAGMENT_SHADER);
    const char* text = fragment.c_str();
    source(shader, 1, &text, nullptr);
    compile(shader);
    GLint taken = 0;
    char message[2000] = "refused without a word";
    status(shader, GL_COMPILE_STATUS, &taken);
    if (!taken) log(shader, sizeof(message), nullptr, message);
    return taken ? "" : message;
  }

  Egl egl;
  EGLDisplay display = nullptr;
  EGLContext context = nullptr;

 private:
  void open(EGLDisplay candidate) {
    if (!candidate || !egl.get<decltype(&eglInitialize)>("eglInitialize")(candidate, nullptr, nullptr)) return;
    if (!egl.get<decltype(&eglBindAPI)>("eglBindAPI")(EGL_OPENGL_ES_API)) return;
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    const EGLContext made = egl.get<decltype(&eglCreateContext)>("eglCreateContext")(candidate, EGL_NO_CONFIG_KHR,
                                                                                     EGL_NO_CONTEXT, attributes);
    const auto make_current = egl.get<decltype(&eglMakeCurrent)>("eglMakeCurrent");
    if (made && make_current(candidate, EGL_NO_SURFACE, EGL_NO_SURFACE, made)) display = candidate, context = made;
  }
};

class SnippetOfEs : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Versions, SnippetOfEs, testing::Values(300, 310, 320));

TEST_P(SnippetOfEs, Compiles) {
  const EsContext es;
  if (!es.context) {
    const char* required = std::getenv("SIDERAY_REQUIRE_CONTEXTS");
    ASSERT_TRUE(!required || !*required) << "contexts are promised, and there is none of OpenGL ES 3.0";
    GTEST_SKIP() << "no OpenGL ES 3.0 here";
  }
  if (es.version() < GetParam()) GTEST_SKIP() << "OpenGL ES here is " << es.version();
  const std::string snippet = "#version " + std::to_string(GetParam()) + " es\n" + sideray_glsl(GetParam());
  EXPECT_EQ(es.complaint(snippet + "in vec3 world, before;\nuniform uint id;\nuniform int light;\nout vec4 result;\n"
                                   "void main() {\n"
                                   "  vec3 c = sideray_translucent(vec3(1.0), world, id);\n"
                                   "  c += sideray_translucent_moving(vec3(1.0), world, id, before);\n"
                                   "  if (sideray_asks(world, id)) c += vec3(1.0);\n"
                                   "  result = vec4(c, sideray_shadow(light) * sideray_ao());\n}\n"),
            "");
  EXPECT_NE(es.complaint(snippet + "out vec4 result;\nvoid main() { result = vec3(1.0); }\n"), "");
}

}  // namespace
}  // namespace sideray::tests::snippet_es_test
