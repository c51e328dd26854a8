// Compiles the snippet by the reference compiler: drivers accept code that is not in their GLSL version, each a
// different kind. (Mesa accepts max() of integers in 1.20, NVIDIA refuses it.)
#include <gtest/gtest.h>
#include <sideray/sideray.h>

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace sideray::tests::strict_glsl_test {
namespace {

constexpr const char* no_compiler = "no glslangValidator (Debian: glslang-tools)";

// Replaces array textures by 3D textures, whose lookups have the same types: the compiler lacks EXT_texture_array.
std::string without_arrays(std::string text) {
  const std::string asked = "#extension GL_EXT_texture_array : require\n";
  const size_t at = text.find(asked);
  if (at == std::string::npos) return text;
  return text.replace(at, asked.size(), "#define sampler2DArray sampler3D\n#define texture2DArray texture3D\n");
}

// Returns the compiler's message about a shader, empty if it accepts it. `stage` is "vert" or "frag".
std::string complaint(const std::string& stage, const std::string& text) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("sideray_strict_" + std::to_string(getpid()) + "." + stage);
  std::ofstream(file) << without_arrays(text);
  FILE* const compiler = popen((SIDERAY_GLSLANG " '" + file.string() + "' 2>&1").c_str(), "r");
  std::string said;
  std::array<char, 1000> line;
  while (compiler && fgets(line.data(), line.size(), compiler)) said += line.data();
  const bool taken = compiler && pclose(compiler) == 0;
  std::filesystem::remove(file);
  return taken ? "" : said.empty() ? "refused without a word" : said;
}

class StrictGlsl : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (!*SIDERAY_GLSLANG) GTEST_SKIP() << no_compiler;
  }
};
INSTANTIATE_TEST_SUITE_P(Versions, StrictGlsl, testing::Values(120, 130, 140, 150, 330, 450));

TEST_P(StrictGlsl, TakesTheSnippet) {
  const bool old = GetParam() < 130;
  const std::string head = "#version " + std::to_string(GetParam()) + "\n";
  const std::string in = old ? "varying" : "in", result = old ? "gl_FragColor" : "result";
  EXPECT_EQ(complaint("frag", head + sideray_glsl(GetParam()) + "uniform float host_id;\n" + in +
                                  " vec3 world, before;\n" + (old ? "" : "out vec4 result;\n") +
                                  "void main() {\n"
                                  "  SIDERAY_UINT id = SIDERAY_UINT(host_id);\n"
                                  "  vec3 c = sideray_translucent(vec3(1.0), world, id);\n"
                                  "  c += sideray_translucent_moving(vec3(1.0), world, id, before);\n"
                                  "  c *= sideray_shadow_color_moving(0, before) * sideray_ao_moving(before);\n"
                                  "  c += float(sideray_explain_moving(before, id) + sideray_explain_masks_moving(before));\n"
                                  "  if (sideray_asks(world, id)) c += vec3(float(sideray_find_layer(world, id)));\n"
                                  "  " +
                                  result + " = vec4(c, sideray_shadow(0) * sideray_ao());\n}\n"),
            "");
}

TEST(StrictReadyShaders, AreTaken) {
  if (!*SIDERAY_GLSLANG) GTEST_SKIP() << no_compiler;
  for (const sideray_ready_program program : {SIDERAY_READY_GLASS, SIDERAY_READY_SHADOWS}) {
    EXPECT_EQ(complaint("vert", sideray_ready_vertex(program)), "");
    EXPECT_EQ(complaint("frag", sideray_ready_fragment(program)), "");
  }
}

}  // namespace
}  // namespace sideray::tests::strict_glsl_test
