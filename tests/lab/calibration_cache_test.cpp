#include "lab/prediction/calibration_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace sideray::lab {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Cache : public testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("sideray_cache_" + name + "_" + std::to_string(getpid()));
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::vector<fs::path> files(const char* extension) const {
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_))
      if (entry.path().extension() == extension) paths.push_back(entry.path());
    return paths;
  }
  static std::string text_of(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  static void write(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

  CalibrationCache cache() const { return CalibrationCache((folder_ / "deep" / "er").string()); }

  const json key_ = {{"scene", "bistro"}, {"size", {1280, 720}}};
  fs::path folder_;
};

scenes::Image picture() {
  scenes::Image image{2, 1, {}, true};
  image.planes.push_back({"R", scenes::Plane::Type::half, {0.1f, 1e6f}, {}});
  image.planes.push_back({"G", scenes::Plane::Type::half, {0.2f, 0.5f}, {}});
  image.planes.push_back({"B", scenes::Plane::Type::half, {0.3f, 0.6f}, {}});
  image.planes.push_back({"A", scenes::Plane::Type::half, {1.0f, 1.0f}, {}});
  return image;
}

TEST_F(Cache, FindsWhatWasKeptUnderTheSameKeyAlone) {
  EXPECT_FALSE(cache().find(key_));
  cache().keep(key_, {{"ms", 1.25}});
  ASSERT_TRUE(cache().find(key_));
  EXPECT_EQ((*cache().find(key_))["ms"], 1.25);
  EXPECT_FALSE(cache().find({{"scene", "bistro"}, {"size", {1280, 721}}}));
  cache().keep(key_, 3);
  EXPECT_EQ(*cache().find(key_), 3);
}

TEST_F(Cache, WhatIsCutOffOrForeignIsNotThere) {
  cache().keep(key_, {{"ms", 1.25}});
  const fs::path file = files(".json").at(0);
  const std::string whole = text_of(file);
  for (size_t length = 0; length < whole.size() - 2; ++length) {
    write(file, whole.substr(0, length));
    EXPECT_FALSE(cache().find(key_)) << length;
  }
  for (const char* text : {"[]", "3", "{}", R"({"schema": 1})", R"({"schema": "1", "key": 3, "value": 4})"}) {
    write(file, text);
    EXPECT_FALSE(cache().find(key_)) << text;
  }
  // Another key whose hash is the same.
  write(file, R"({"schema": 1, "key": {"scene": "forest"}, "value": {"ms": 7}})");
  EXPECT_FALSE(cache().find(key_));
  write(file, whole);
  EXPECT_TRUE(cache().find(key_));
}

TEST_F(Cache, PicturesComeBackToTheBit) {
  EXPECT_FALSE(cache().find_picture(key_));
  cache().keep_picture(key_, picture());
  const std::optional<scenes::Image> read = cache().find_picture(key_);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->find("R")->values, picture().find("R")->values) << "beyond what halves hold";
  EXPECT_EQ(read->find("B")->values, picture().find("B")->values);
}

TEST_F(Cache, APictureThatWasExchangedIsNotThere) {
  cache().keep_picture(key_, picture());
  const json other = "other";
  scenes::Image changed = picture();
  changed.planes[0].values[0] = 0.9f;
  cache().keep_picture(other, changed);
  const std::vector<fs::path> pictures = files(".exr");
  ASSERT_EQ(pictures.size(), 2u);
  const std::string first = text_of(pictures[0]);
  fs::copy_file(pictures[1], pictures[0], fs::copy_options::overwrite_existing);
  EXPECT_NE(cache().find_picture(key_).has_value(), cache().find_picture(other).has_value());
  write(pictures[0], first.substr(0, first.size() / 2));
  EXPECT_NE(cache().find_picture(key_).has_value(), cache().find_picture(other).has_value());
}

TEST_F(Cache, WhatCannotBeWrittenIsNotKept) {
  fs::create_directories(folder_);
  write(folder_ / "file", "");
  const CalibrationCache blocked((folder_ / "file" / "sub").string());
  blocked.keep(key_, 1);
  blocked.keep_picture(key_, picture());
  EXPECT_FALSE(blocked.find(key_));
  const CalibrationCache none("");
  none.keep(key_, 1);
  EXPECT_FALSE(none.find(key_));
}

TEST_F(Cache, LiesWhereTheEnvironmentSays) {
  const auto folder = [](const char* cache, const char* home, const char* off) {
    setenv("XDG_CACHE_HOME", cache, 1);
    setenv("HOME", home, 1);
    setenv("SIDERAY_CACHE", off, 1);
    return calibration_folder();
  };
  EXPECT_EQ(folder("/c", "/h", ""), "/c/sideray");
  EXPECT_EQ(folder("", "/h", ""), "/h/.cache/sideray");
  EXPECT_EQ(folder("relative", "/h", ""), "/h/.cache/sideray") << "the specification ignores it";
  EXPECT_EQ(folder("", "", ""), "");
  EXPECT_EQ(folder("/c", "/h", "off"), "");
}

}  // namespace
}  // namespace sideray::lab
