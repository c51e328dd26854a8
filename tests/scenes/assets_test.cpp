#include <gmock/gmock.h>

#include <optional>
#include <regex>

#include "scenes/images/images.h"
#include "scenes/support.h"

// Tests real files of many exporters, beside the checkout. Skipped with a message where they are absent.
namespace sideray::scenes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

fs::path assets() {
  return fs::path(SIDERAY_SOURCE_DIR).parent_path() / "shared" / "assets";
}

#define SKIP_WITHOUT_ASSETS() \
  if (!fs::exists(assets())) GTEST_SKIP() << "no test content at " << assets()

size_t drawn_triangles(const Content& content) {
  size_t triangles = 0;
  for (const Object& object : content.objects) triangles += content.meshes[object.mesh].indices.size() / 3;
  return triangles;
}

struct Row {
  fs::path path;
  size_t triangles;
};

// The rows of INDEX.md: | folder | `file` (n) | MB | triangles / n drawn | materials | used | required | ...
std::vector<Row> index_rows() {
  std::vector<Row> rows;
  std::ifstream index(assets() / "INDEX.md");
  const std::regex form(R"(\| (\w+) \| `([^`]+)`[^|]*\|[^|]*\| (\d+)(?: / (\d+) drawn)? \|.*)");
  std::string line;
  while (std::getline(index, line)) {
    std::smatch match;
    if (!std::regex_match(line, match, form)) continue;
    const std::string triangles = match[4].matched ? match[4] : match[3];
    rows.push_back({assets() / match[1].str() / match[2].str(), std::stoul(triangles)});
  }
  return rows;
}

TEST(Assets, TriangleCountsAreThoseOfTheIndex) {
  SKIP_WITHOUT_ASSETS();
  const std::vector<Row> rows = index_rows();
  EXPECT_GT(rows.size(), 30u);
  for (const Row& row : rows) {
    SCOPED_TRACE(row.path);
    std::optional<Content> content;
    EXPECT_EQ(message_of([&] { content = load(row.path); }), "");
    if (content) {
      EXPECT_EQ(drawn_triangles(*content), row.triangles);
    }
  }
}

TEST(Assets, EnvironmentMapsAreRead) {
  SKIP_WITHOUT_ASSETS();
  for (const fs::directory_entry& entry : fs::directory_iterator(assets() / "EnvMaps")) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".hdr" && extension != ".exr") continue;
    SCOPED_TRACE(entry.path());
    const Image image = read_image(entry.path());
    EXPECT_EQ(image.width, 2 * image.height) << "lat-long";
    const Plane* red = image.find("R");
    ASSERT_NE(red, nullptr);
    // Daylight from above: the upper half is brighter than the lower one.
    double upper = 0, lower = 0;
    for (size_t i = 0; i < red->values.size(); ++i)
      (i < red->values.size() / 2 ? upper : lower) += double{red->values[i]};
    EXPECT_GT(upper, lower);
    std::vector<uint8_t> bytes = bytes_of(entry.path());
    bytes.resize(bytes.size() / 2);
    const ScratchFolder folder;
    put_bytes(folder / ("cut" + extension), bytes);
    EXPECT_THAT(message_of([&] { read_image(folder / ("cut" + extension)); }), HasSubstr("cut"));
  }
}

TEST(Assets, JpegsAreDecodedAndCutOnesRefused) {
  SKIP_WITHOUT_ASSETS();
  size_t pictures = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(assets() / "TeaSet")) {
    if (entry.path().extension() != ".jpg" && entry.path().extension() != ".jpeg") continue;
    ++pictures;
    std::vector<uint8_t> bytes = bytes_of(entry.path());
    const Decoded decoded = decode_image(bytes, "picture");
    EXPECT_EQ(decoded.rgba.size(), size_t{decoded.width} * decoded.height * 4);
    bytes.resize(bytes.size() / 2);
    EXPECT_THAT(message_of([&] { decode_image(bytes, "picture"); }), HasSubstr("ends too early"));
  }
  EXPECT_GT(pictures, 0u);
}

}  // namespace
}  // namespace sideray::scenes
