#include "gl/gl_contexts.h"

#include <fmt/format.h>

#include <cstdlib>

#include "model/failure.h"

// OSMesaDestroyContext does not free its buffer (Mesa 22.3): 160 bytes a context that are not ours to free.
extern "C" __attribute__((visibility("default"), used)) const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\n";
}

namespace sideray::gl {
namespace {

std::optional<DeviceInfo> first_of(Platform platform) {
  for (const DeviceInfo& device : list_devices())
    if (device.platform == platform && device.usable) return device;
  return std::nullopt;
}

}  // namespace

std::unique_ptr<Context> open_context(const std::string& name, Profile profile) {
  setenv("SIDERAY_GL_DEBUG", "1", 1);
  const Platform platform = name == "device"        ? Platform::egl_device
                            : name == "surfaceless" ? Platform::egl_surfaceless
                                                    : Platform::osmesa;
  const std::optional<DeviceInfo> device = first_of(platform);
  if (!device) return nullptr;
  try {
    return Context::create("auto", device->id, profile);
  } catch (const Failure&) {
    if (profile == Profile::core) throw;
    return nullptr;
  }
}

bool is_required(const std::string& name) {
  const char* list = std::getenv("SIDERAY_REQUIRE_CONTEXTS");
  return list != nullptr && (fmt::format(",{},", list)).find(fmt::format(",{},", name)) != std::string::npos;
}

std::vector<std::string> driver_contexts() {
  std::vector<std::string> names{"surfaceless", "osmesa"};
  if (is_required("device")) names.emplace_back("device");
  return names;
}

std::string name_of_driver_and_profile(const testing::TestParamInfo<std::tuple<std::string, Profile>>& suite) {
  return std::get<0>(suite.param) + (std::get<1>(suite.param) == Profile::core ? "_core" : "_compatibility");
}

std::vector<std::string> take_problems(Context& context) {
  std::vector<std::string> problems = context.take_errors();
  for (GLenum code = context.functions().GetError(); code != GL_NO_ERROR; code = context.functions().GetError())
    problems.push_back(fmt::format("glGetError 0x{:x}", code));
  return problems;
}

void EveryContext::SetUp() {
  context = open_context(GetParam());
  if (context != nullptr) return;
  if (is_required(GetParam())) FAIL() << "required context \"" << GetParam() << "\" is not available here";
  GTEST_SKIP() << "no context \"" << GetParam() << "\" on this machine";
}

void EveryContext::TearDown() {
  if (context == nullptr) return;
  EXPECT_EQ(take_problems(*context), std::vector<std::string>{});
}

Target::Target(const Functions& gl, GLenum internal_format, int side_px)
    : side(side_px), gl_(gl), color_(gl), framebuffer_(gl) {
  gl.BindTexture(GL_TEXTURE_2D, color_.id());
  gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), side, side, 0, GL_RGBA, GL_FLOAT, nullptr);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color_.id(), 0);
  EXPECT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
  gl.Viewport(0, 0, side, side);
  gl.ClearColor(0, 0, 0, 0);
  gl.Clear(GL_COLOR_BUFFER_BIT);
}

void Target::bind() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl_.Viewport(0, 0, side, side);
}

std::vector<uint8_t> Target::read_rgba8() const {
  bind();
  std::vector<uint8_t> pixels(static_cast<size_t>(side) * static_cast<size_t>(side) * 4);
  gl_.ReadPixels(0, 0, side, side, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  return pixels;
}

std::vector<float> Target::read_rgba32f() const {
  bind();
  std::vector<float> pixels(static_cast<size_t>(side) * static_cast<size_t>(side) * 4);
  gl_.ReadPixels(0, 0, side, side, GL_RGBA, GL_FLOAT, pixels.data());
  return pixels;
}

void draw_triangle(const Functions& gl, const float (&corners)[6], const std::string& color_expression) {
  const Program program(gl, "test triangle",
                        "#version 330 core\nlayout(location = 0) in vec2 corner;\n"
                        "void main() { gl_Position = vec4(corner, 0.0, 1.0); }\n",
                        "#version 330 core\nout vec4 color;\nvoid main() { color = " + color_expression + "; }\n");
  const VertexArray vertices(gl);
  const Buffer buffer(gl);
  gl.BindVertexArray(vertices.id());
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer.id());
  gl.BufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
  gl.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.EnableVertexAttribArray(0);
  program.use();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.UseProgram(0);
}

}  // namespace sideray::gl
