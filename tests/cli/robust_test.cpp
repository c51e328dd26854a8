// Tests broken and hostile files: exit code 0 or 1, one line, within 20 s and a few gigabytes.
#include "cli/program.h"

namespace sideray::cli_tests {
namespace {

fs::path assets() {
  const char* folder = std::getenv("SIDERAY_ASSETS");
  return folder ? fs::path(folder) : fs::path(SIDERAY_SOURCE_DIR).parent_path() / "shared" / "assets";
}

std::vector<fs::path> hostile_files() {
  std::vector<fs::path> paths;
  for (const char* set : {"Invalid", "AssetGenerator06"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(assets() / set))
      if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

class Robust : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!fs::exists(assets() / "Invalid")) GTEST_SKIP() << "no test content at " << assets();
  }

  // Returns limits for the shell's children. Sanitizers reserve terabytes of addresses, so they run without the second.
  static std::string limits() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return "timeout 20";
#else
    return "ulimit -v 8000000; timeout 20";
#endif
  }

  void expect_content_or_one_line(const fs::path& scene, const std::string& arguments) const {
    SCOPED_TRACE("sideray " + arguments);
    const Outcome outcome = run(arguments, limits());
    ASSERT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 1) << outcome.exit_code << ": " << outcome.errors;
    if (outcome.exit_code == 0) return;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(outcome.error_lines(), 1u) << outcome.errors;
    EXPECT_TRUE(outcome.errors.starts_with("sideray: ")) << outcome.errors;
    EXPECT_NE(outcome.errors.find(scene.filename()), std::string::npos) << outcome.errors;
    EXPECT_NE(outcome.errors.find("; "), std::string::npos) << outcome.errors;
  }
};

TEST_F(Robust, InfoOfEveryHostileFile) {
  const std::vector<fs::path> scenes = hostile_files();
  EXPECT_GT(scenes.size(), 300u);
  for (const fs::path& scene : scenes) expect_content_or_one_line(scene, "info '" + scene.string() + "'");
}

TEST_F(Robust, PicturesOfSomeHostileFiles) {
  const std::vector<fs::path> scenes = hostile_files();
  size_t pictures = 0;
  for (size_t i = 0; i < scenes.size(); i += 30) {
    const std::string mode = i % 60 == 0 ? "raster" : "raytraced";
    fs::remove(path("o.png"));
    expect_content_or_one_line(scenes[i],
                               "render '" + scenes[i].string() + "' -o o.png --size 16x16 --translucency " + mode);
    pictures += fs::exists(path("o.png"));
  }
  EXPECT_GT(pictures, 2u);
}

}  // namespace
}  // namespace sideray::cli_tests
