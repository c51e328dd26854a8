#include "gl/resources/program.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "gl/gl_contexts.h"
#include "model/failure.h"
#include "shaders/sources.h"

namespace sideray::gl {
namespace {

using testing::HasSubstr;
using testing::Not;

class ProgramTest : public EveryContext {};
INSTANTIATE_TEST_SUITE_P(All, ProgramTest, testing::ValuesIn(driver_contexts()),
                         [](const auto& suite) { return suite.param; });

constexpr const char* vertex_text = "void main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }\n";

std::string vertex(int version) {
  return fmt::format("#version {}\n{}", version, vertex_text);
}

std::string failure_of(const Functions& gl, const std::string& vertex_shader, const std::string& fragment_shader) {
  try {
    const Program program(gl, "glass", vertex_shader, fragment_shader);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_GL_FAILED);
    return failure.what();
  }
  ADD_FAILURE() << "it compiled";
  return "";
}

TEST_P(ProgramTest, CompileErrorNamesProgramStageFileAndLine) {
  const std::string_view shading = shaders::source("shading.h");
  const auto lines = std::count(shading.begin(), shading.end(), '\n');
  const std::string text =
      assemble_shader({{"shading.h"}, {}, "330 core"}) + "out float x;\nvoid main() { x = no_such_name; }\n";
  const std::string message = failure_of(gl(), vertex(330), text);
  EXPECT_THAT(message, HasSubstr("program \"glass\": its fragment shader does not compile"));
  EXPECT_THAT(message, HasSubstr("no_such_name"));
  EXPECT_THAT(message, HasSubstr("source 1 = shading.h"));
  if (gl().software) {
    EXPECT_THAT(message, HasSubstr(fmt::format(":{}(", lines + 2)));
  }
  EXPECT_EQ(message.find('\n'), std::string::npos);
  take_problems(*context);  // a failed compile is also a message of type error
}

TEST_P(ProgramTest, LinkErrorNamesTheProgram) {
  const std::string message =
      failure_of(gl(), "#version 330\nout float mixed;\nvoid main() { mixed = 1.0; gl_Position = vec4(1.0); }\n",
                 "#version 330\nin vec3 mixed;\nout vec4 c;\nvoid main() { c = mixed.xyzz; }\n");
  EXPECT_THAT(message, HasSubstr("program \"glass\" does not link"));
  EXPECT_THAT(message, HasSubstr("mixed"));
  take_problems(*context);
}

TEST_P(ProgramTest, DefinesAndUniformsReachThePicture) {
  const Target target(gl(), GL_RGBA32F, 4);
  const Program program(gl(), "uniforms",
                        "#version 330\nvoid main() {\n"
                        "  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);\n}\n",
                        "#version 330\nuniform vec3 tint;\nuniform mat4 m;\nuniform uint id;\nout vec4 color;\n"
                        "void main() { color = m * vec4(tint, SCALE + float(id)); }\n",
                        {"SCALE 0.25"});
  const VertexArray vertices(gl());
  gl().BindVertexArray(vertices.id());
  program.use();
  glm::mat4 m(1.0f);
  m[3] = glm::vec4(1, 2, 3, 1);
  program.set("tint", glm::vec3(0.5f, 0.25f, 0.125f));
  program.set("m", m);
  program.set("id", 2u);
  program.set("not_there", 1.0f);
  EXPECT_EQ(program.uniform("not_there"), -1);
  gl().DrawArrays(GL_TRIANGLES, 0, 3);
  const std::vector<float> pixels = target.read_rgba32f();
  EXPECT_EQ(std::vector<float>(pixels.begin(), pixels.begin() + 4),
            (std::vector<float>{0.5f + 2.25f, 0.25f + 4.5f, 0.125f + 6.75f, 2.25f}));
}

TEST_P(ProgramTest, AbandonedObjectsAreNotDeleted) {
  Texture texture(gl());
  gl().BindTexture(GL_TEXTURE_2D, texture.id());
  gl().BindTexture(GL_TEXTURE_2D, 0);
  const uint32_t id = texture.abandon();
  EXPECT_FALSE(texture);
  EXPECT_EQ(gl().IsTexture(id), GL_TRUE);
  { const Texture adopted(gl(), id); }
  EXPECT_EQ(gl().IsTexture(id), GL_FALSE);
}

TEST_P(ProgramTest, FencePassesOnceTheWorkIsDone) {
  const Target target(gl(), GL_RGBA8, 64);
  draw_triangle(gl(), test_corners, "vec4(1.0)");
  Fence fence(gl());
  EXPECT_TRUE(fence.wait(10'000'000'000u));
  EXPECT_TRUE(fence.wait(0));
}

TEST_P(ProgramTest, MissingShaderFileIsNamed) {
  try {
    assemble_shader({{"no_such_file.glsl"}, {}, "330 core"});
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_INTERNAL);
    EXPECT_THAT(failure.what(), HasSubstr("no_such_file.glsl"));
  }
}

// Every function of the shading model, so that none is dropped before it is checked.
constexpr const char* shading_main = R"(
uniform vec3 a;
uniform vec4 b;
uniform SrMaterial m;
uniform SrTexels t;
uniform SrLight light;
out vec4 color;
void main() {
  SrSurface s = sr_seen(sr_filmed(sr_surface(m, t, sr_perturb(a, b, a, b.x), a), m, t, a), a, sr_latlong(a), b.y);
  SrIncidence i = sr_incidence(light, a);
  SrBlend blend = sr_blend(s, a, int(b.x));
  vec3 sum = sr_reflect_light(s, a, i.to_light) * i.irradiance + sr_environment(s, b.y, SrSurroundings(a, a, a, a)) * blend.cover +
             blend.through + sr_specular_albedo(s) + sr_fresnel(s.f0, s.f90, i.distance) + sr_dominant(a, b.xyz, b.y) +
             sr_transmittance(s, a) + sr_emitted(s) + (sr_faces(s, a) ? a : b.xyz);
  color = vec4(sum, 1.0);
}
)";

TEST_P(ProgramTest, ShadingModelCompiles) {
  const Program program(gl(), "shading", vertex(330), assemble_shader({{"shading.h"}, {}, "330 core"}) + shading_main);
  EXPECT_NE(program.uniform("a"), -1);
}

constexpr const char* snippet_main =
    "uniform uint id;\nin vec3 world;\nout vec4 color;\n"
    "void main() { color = vec4(sideray_translucent(vec3(1.0), world, id), 1.0); }\n";
constexpr const char* moving_main =
    "uniform uint id;\nin vec3 world;\nout vec4 color;\n"
    "void main() { color = vec4(sideray_translucent_moving(vec3(1.0), world, id, world), 1.0); }\n";
constexpr const char* masks_main =
    "uniform int light;\nout vec4 color;\n"
    "void main() { color = vec4(sideray_shadow(light), sideray_shadow(3), sideray_ao(), 1.0); }\n";

void expect_snippet_compiles(Context& context, int version, const char* main, std::vector<const char*> uniforms) {
  const std::string fragment = fmt::format("#version {}\n{}\n{}", version, shaders::source("sideray.glsl"), main);
  const std::string world_vertex = fmt::format(
      "#version {}\nout vec3 world;\nvoid main() {{ world = vec3(float(gl_VertexID), float(gl_VertexID & 1), 2.0); "
      "gl_Position = vec4(world, 1.0); "
      "}}\n",
      version);
  try {
    const Program program(context.functions(), "snippet", world_vertex, fragment);
    for (const char* name : uniforms) EXPECT_NE(program.uniform(name), -1) << name;
  } catch (const Failure& failure) {
    ADD_FAILURE() << "#version " << version << ": " << failure.what();
  }
}

void expect_snippet_compiles(Context& context, int version) {
  expect_snippet_compiles(
      context, version, snippet_main,
      {"sideray_radiance", "sideray_distance", "sideray_surface_id", "sideray_layers", "sideray_viewport",
       "sideray_eye", "sideray_near_plane", "sideray_match", "sideray_match_threshold", "sideray_subpixel",
       "sideray_rate", "sideray_ray_from_pixel", "sideray_cache_size"});
  expect_snippet_compiles(context, version, moving_main, {"sideray_clip_from_world", "sideray_cache_size"});
  expect_snippet_compiles(context, version, masks_main,
                          {"sideray_shadow_masks", "sideray_ao_mask", "sideray_shadow_layer", "sideray_mask_size",
                           "sideray_has_ao", "sideray_mask_viewport"});
}

TEST_P(ProgramTest, SnippetCompilesInCoreVersions) {
  for (const int version : {150, 330, 450}) {
    if (10 * gl().version < version) continue;
    expect_snippet_compiles(*context, version);
  }
}

TEST_P(ProgramTest, SnippetCompilesInEveryVersionOfACompatibilityContext) {
  context.reset();
  context = open_context(GetParam(), Profile::compatibility);
  if (context == nullptr) GTEST_SKIP() << "no compatibility profile here";
  for (const int version : {130, 150, 330, 450}) {
    if (version >= 330 && 10 * gl().version < version) continue;
    expect_snippet_compiles(*context, version);
  }
}

// See delete_program() of gl/resources/objects.cpp.
TEST_P(ProgramTest, ThatIsDeletedIsNotCurrent) {
  GLint current = 0;
  {
    const Program program(gl(), "glass", vertex(330), "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n");
    program.use();
  }
  gl().GetIntegerv(GL_CURRENT_PROGRAM, &current);
  EXPECT_EQ(current, 0);
  const Program other(gl(), "glass", vertex(330), "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n");
  other.use();
  { const Program unused(gl(), "glass", vertex(330), "#version 330\nout vec4 c;\nvoid main() { c = vec4(0.0); }\n"); }
  gl().GetIntegerv(GL_CURRENT_PROGRAM, &current);
  EXPECT_EQ(static_cast<GLuint>(current), other.id());
}

}  // namespace
}  // namespace sideray::gl
