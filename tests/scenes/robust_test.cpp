#include <gmock/gmock.h>

#include <chrono>
#include <map>
#include <optional>
#include <random>

#include "fuzz/memory_file.h"
#include "scenes/support.h"

// Tests files that are broken, truncated or hostile: each is refused by one clear line, or loaded as content that a
// scene accepts.
namespace sideray::scenes::robust_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;

fs::path assets() {
  const char* folder = std::getenv("SIDERAY_ASSETS");
  return folder ? fs::path(folder) : fs::path(SIDERAY_SOURCE_DIR).parent_path() / "shared" / "assets";
}

fs::path corpus() {
  return fs::path(SIDERAY_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "scene";
}

bool is_scene(const fs::path& path) {
  return path.extension() == ".gltf" || path.extension() == ".glb";
}

std::vector<fs::path> scenes_below(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && is_scene(entry.path())) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Returns "" if the file loads, when a scene must also take its content; otherwise the message, which must be one clear
// line.
std::string outcome(const std::string& path) {
  std::optional<Content> content;
  const std::string message = message_of([&] { content = load(path); });
  if (!content) {
    EXPECT_THAT(message, HasSubstr(path));
    EXPECT_THAT(message, MatchesRegex("[^\n\r\x1b]+: [^\n\r\x1b]+; [^\n\r\x1b]+"));
    return message;
  }
  EXPECT_EQ(message_of([&] {
              Scene scene = Scene::create().value();
              fill(scene, *content, std::vector<bool>(content->objects.size(), true));
              info_json(*content);
              info_text(*content);
            }),
            "");
  return "";
}

// The errors that the Khronos validator reports for the file; nothing where there is no report.
std::optional<int> validator_errors(const fs::path& path) {
  std::ifstream report(path.string() + ".report.json");
  if (!report) return std::nullopt;
  return nlohmann::json::parse(report).at("issues").at("numErrors").get<int>();
}

// Files that are refused although the validator, which does not check whether they can be drawn, finds no fault.
const std::map<std::string, std::string>& refused_although_valid() {
  static const std::string buffers = "glTF-Validator/base/data/buffer/", no_data = "neither a uri nor a binary chunk";
  static const std::map<std::string, std::string> reasons{
      // Nothing says where the data are.
      {buffers + "custom_property.gltf", no_data},
      {buffers + "valid_placeholder.glb", no_data},
      {"glTF-Validator/base/data/json/integer_written_as_float.gltf", no_data},
      {"glTF-Validator/base/data/root/named_objects.gltf", no_data},
      {"glTF-Validator/base/data/root/unused_objects.gltf", no_data},
      {"glTF-Validator/base/data/mesh/valid.gltf", "invalid bufferView"},
      // One byte, not in base64.
      {buffers + "data_uri.glb", "not octets in base64"},
      // Nothing is fetched from a network.
      {buffers + "non_relative_uri.gltf", "not in the scene's folder"}};
  return reasons;
}

TEST(Robust, EveryHostileFileIsRefusedByOneLineOrLoads) {
  if (!fs::exists(assets() / "Invalid")) GTEST_SKIP() << "no test content at " << assets();
  int files = 0, refused = 0, valid = 0;
  for (const char* set : {"Invalid", "AssetGenerator06"}) {
    for (const fs::path& path : scenes_below(assets() / set)) {
      SCOPED_TRACE(path);
      const auto start = std::chrono::steady_clock::now();
      const std::string message = outcome(path);
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
      ++files;
      refused += !message.empty();
      if (validator_errors(path) != 0) continue;
      ++valid;
      const auto known = refused_although_valid().find(fs::relative(path, assets() / set).string());
      if (known == refused_although_valid().end())
        EXPECT_EQ(message, "");
      else
        EXPECT_THAT(message, HasSubstr(known->second));
    }
  }
  EXPECT_GT(files, 300);
  EXPECT_GT(refused, 50);
  EXPECT_GT(valid, 100);
}

void expect_refused_where_cut(size_t step) {
  size_t bytes = 0;
  for (const fs::path& path : scenes_below(corpus())) {
    SCOPED_TRACE(path);
    std::vector<uint8_t> whole = bytes_of(path);
    if (path.extension() == ".gltf" && whole.back() == '\n') whole.pop_back();  // JSON is complete without it
    tests::MemoryFile cut(path.extension());
    for (size_t length = bytes % step; length < whole.size(); length += step) {
      cut.put(std::span(whole).first(length));
      ASSERT_NE(outcome(cut.path()), "") << "cut to " << length << " of " << whole.size() << " bytes";
    }
    bytes += whole.size();
  }
}

TEST(Robust, AFileCutSomewhereIsRefused) {
  expect_refused_where_cut(5);
}

TEST(SlowRobust, AFileCutAnywhereIsRefused) {
  expect_refused_where_cut(1);
}

TEST(Robust, ABuiltInSceneCutAnywhereIsRefused) {
  const ScratchFolder folder;
  write_glb(folder / "whole.glb", load("panes"));
  const std::vector<uint8_t> whole = bytes_of(folder / "whole.glb");
  // Cuts header and JSON at each byte, and the binary chunk that follows at few.
  const size_t frame = std::min<size_t>(whole.size(), 4096);
  tests::MemoryFile cut(".glb");
  for (size_t length = 0; length < whole.size(); length += length < frame ? 1 : 997) {
    cut.put(std::span(whole).first(length));
    ASSERT_NE(outcome(cut.path()), "") << "cut to " << length << " of " << whole.size() << " bytes";
  }
}

// Replaces every `step`th byte of the corpus, one at a time, by values with one bit changed and by characters that have
// a meaning in JSON.
void expect_refused_or_loaded(size_t step) {
  std::mt19937 random(1);
  size_t loaded = 0, refused = 0, bytes = 0;
  for (const fs::path& path : scenes_below(corpus())) {
    const std::vector<uint8_t> whole = bytes_of(path);
    tests::MemoryFile file(path.extension());
    for (size_t at = bytes % step; at < whole.size(); at += step) {
      static constexpr char characters[] = "\"0-9e.]}[{,:\x00\xff";
      const uint8_t replacement = random() % 2 ? static_cast<uint8_t>(whole[at] ^ (1u << random() % 8))
                                               : static_cast<uint8_t>(characters[random() % (sizeof(characters) - 1)]);
      std::vector<uint8_t> changed = whole;
      changed[at] = replacement;
      file.put(changed);
      const std::string message = outcome(file.path());
      ++(message.empty() ? loaded : refused);
      ASSERT_FALSE(testing::Test::HasFailure())
          << path << ", byte " << at << " is " << int{replacement} << " instead of " << int{whole[at]};
    }
    bytes += whole.size();
  }
  EXPECT_GT(refused, 500u);
  EXPECT_GT(loaded, 500u) << "bytes of names and of geometry can change";
}

TEST(Robust, AChangedByteIsRefusedOrLoads) {
  expect_refused_or_loaded(16);
}

TEST(SlowRobust, AnyChangedByteIsRefusedOrLoads) {
  expect_refused_or_loaded(1);
}

}  // namespace
}  // namespace sideray::scenes::robust_test
