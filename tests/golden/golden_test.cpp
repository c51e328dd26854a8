// Compares small pictures of every way of drawing with those in the repository. cases.json lists them; a line there and
// `cmake --build build --target update_golden` add one. tests/golden/README.md explains the bounds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <utility>

#include "cli/program.h"
#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::golden_tests {
namespace {

namespace fs = std::filesystem;
using cli_tests::text_of;
using nlohmann::json;
using nlohmann::ordered_json;

const fs::path kept = SIDERAY_SOURCE_DIR "/tests/golden", drawn = SIDERAY_BINARY_DIR "/golden";
// In mean FLIP. Drivers differ in edges and texture filters; one driver on another processor in the last bits alone.
// Drivers decode sRGB texels and round by up to 1e-3, which FLIP sees on large flat fields: 0.019 is the most between
// llvmpipe and NVIDIA (580.159) over all cases.
constexpr double on_any_driver = 0.02, on_the_same_driver = 0.001;

// Where `same_as` names another case, both must have the same bits, and only the other one has an image. `frames`: a
// sequence of so many is drawn, and its last picture compared; 0: a single picture.
struct Case {
  std::string name, scene, options, same_as;
  unsigned frames = 0;

  fs::path picture() const { return drawn / (name + (frames > 0 ? fmt::format(".{:04}.exr", frames - 1) : ".exr")); }
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

std::vector<Case> cases() {
  std::vector<Case> list;
  for (const json& c : json::parse(text_of(kept / "cases.json")))
    list.push_back({c.at("name"), c.at("scene"), c.at("options"), c.value("same_as", ""), c.value("frames", 0u)});
  return list;
}

Case case_named(const std::string& name) {
  for (const Case& c : cases())
    if (c.name == name) return c;
  ADD_FAILURE() << "no case " << name;
  return {};
}

std::string command(const Case& c) {
  return "cd '" SIDERAY_SOURCE_DIR "/tests/golden' && SIDERAY_ISA=avx2 '" SIDERAY_BINARY_DIR "/sideray' render " + c.scene + " --size 96x54 " + c.options +
         (c.frames > 0 ? fmt::format(" --frames 0-{} -o '{}'", c.frames - 1, (drawn / (c.name + ".####.exr")).string())
                       : fmt::format(" -o '{}'", c.picture().string()));
}

// Returns the device's strings on which bits depend.
json device_of(const json& stats) {
  const json& device = stats.at("device");
  return {{"renderer", device.at("renderer")}, {"version", device.at("version")}, {"isa", device.value("isa", "")}};
}

json draw(const Case& c) {
  fs::create_directories(drawn);
  const std::string stats = (drawn / (c.name + ".json")).string(), errors = (drawn / (c.name + ".txt")).string();
  const int status = std::system((command(c) + " --stats '" + stats + "' 2>'" + errors + "'").c_str());
  EXPECT_EQ(status, 0) << command(c) << "\n" << text_of(errors);
  if (status != 0) return {};
  // A sequence has a line for each frame, of the same device.
  const std::string text = text_of(stats);
  return json::parse(c.frames > 0 ? text.substr(0, text.find('\n')) : text);
}

// Pixels that differ, and by how much at most.
std::pair<size_t, float> difference(const scenes::Image& a, const scenes::Image& b) {
  std::vector<bool> differs(size_t{a.width} * a.height);
  float most = 0;
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>&x = a.find(channel)->values, &y = b.find(channel)->values;
    for (size_t i = 0; i < x.size(); ++i)
      if (x[i] != y[i]) differs[i] = true, most = std::max(most, std::abs(x[i] - y[i]));
  }
  return {static_cast<size_t>(std::count(differs.begin(), differs.end(), true)), most};
}

bool updates() {
  return std::getenv("SIDERAY_UPDATE_GOLDEN") != nullptr;
}

// Where no OpenGL device is, there is nothing to compare; SIDERAY_GL_CONTEXTS promises one.
// Where contexts are required, a missing one fails the drawing instead of skipping it.
bool can_draw() {
  return std::getenv("SIDERAY_REQUIRE_CONTEXTS") != nullptr ||
         std::system("'" SIDERAY_BINARY_DIR "/sideray' devices --json | grep -q '\"usable\": true'") == 0;
}

void update(const Case& c, const json& device) {
  const fs::path file = kept / (c.name + ".exr"), fresh = c.picture();
  if (fs::exists(file)) {
    const scenes::Image now = scenes::read_image(fresh.string()), before = scenes::read_image(file.string());
    if (now.width == before.width && now.height == before.height) {
      const auto [pixels, most] = difference(now, before);
      std::cout << c.name << ": FLIP " << *lab::compare(now, before).metrics.flip << " to the old one, " << pixels
                << " pixels differ, by at most " << most << "\n";
      if (pixels == 0) return;  // the same picture in other bytes is no change to review
    }
  } else {
    std::cout << c.name << ": new\n";
  }
  fs::copy_file(fresh, file, fs::copy_options::overwrite_existing);
  const fs::path list = kept / "recorded.json";
  ordered_json recorded = fs::exists(list) ? ordered_json::parse(text_of(list)) : ordered_json::object();
  recorded[c.name] = device;
  std::ofstream(list) << recorded.dump(1) << "\n";
}

void expect_same(const Case& c, const Case& other) {
  if (draw(c).is_null() || draw(other).is_null()) return;
  const auto [pixels, most] = difference(scenes::read_image(c.picture().string()),
                                         scenes::read_image(other.picture().string()));
  EXPECT_EQ(pixels, 0u) << "differ, by at most " << most << "\n" << command(c) << "\n" << command(other);
}

class Golden : public testing::TestWithParam<Case> {};

TEST_P(Golden, looks_as_it_did) {
  const Case& c = GetParam();
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  if (!c.same_as.empty()) return expect_same(c, case_named(c.same_as));
  const json stats = draw(c);
  if (stats.is_null()) return;
  const json device = device_of(stats);
  if (updates()) return update(c, device);
  const fs::path file = kept / (c.name + ".exr");
  ASSERT_TRUE(fs::exists(file)) << "no golden image; look at " << c.picture() << " and build the target update_golden";
  const scenes::Image now = scenes::read_image(c.picture().string()),
                      wanted = scenes::read_image(file.string());
  const lab::Comparison compared = lab::compare(now, wanted);
  const json recorded = json::parse(text_of(kept / "recorded.json")).value(c.name, json());
  const bool same_driver = recorded == device;
  const auto [pixels, most] = difference(now, wanted);
  std::cout << "  FLIP " << compared.metrics.flip.value_or(1) << ", " << pixels << " pixels differ, by at most " << most
            << (same_driver ? "; as recorded: " : "; recorded on another driver: ") << device.dump() << "\n";
  EXPECT_EQ(compared.metrics.nonfinite, 0u);
  EXPECT_LE(compared.metrics.flip.value_or(1), same_driver ? on_the_same_driver : on_any_driver);
  EXPECT_TRUE(pixels == 0 || !same_driver || !std::getenv("SIDERAY_GOLDEN_BITS"));
  if (!HasFailure()) return;
  const std::string map = (drawn / (c.name + ".flip.png")).string();
  scenes::write_png(map, now.width, now.height, lab::false_colours(compared.flip_map));
  std::cout << "  look at " << map << " and " << c.picture() << " beside " << file
            << "\n  again: " << command(c) << "\n";
}

// A golden image without its line is never looked at.
TEST(GoldenList, HasALineForEveryImage) {
  std::vector<std::string> names;
  for (const Case& c : cases())
    if (c.same_as.empty()) names.push_back(c.name);
  uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kept)) {
    if (entry.path().extension() != ".exr") continue;
    EXPECT_EQ(std::count(names.begin(), names.end(), entry.path().stem().string()), 1) << entry.path();
    bytes += entry.file_size();
  }
  EXPECT_LE(bytes, uintmax_t{2} << 20);
}

// Two cases with the same picture do not test their options: one needs a scene where they show, or `same_as` where the
// two agree by design.
TEST(GoldenList, HasNoImageTwice) {
  std::map<std::vector<float>, std::string> seen;
  for (const Case& c : cases()) {
    if (!c.same_as.empty()) {
      EXPECT_EQ(case_named(c.same_as).same_as, "") << c << ": name the case that has the image";
      continue;
    }
    const scenes::Image image = scenes::read_image((kept / (c.name + ".exr")).string());
    std::vector<float> values;
    for (const char* channel : {"R", "G", "B"})
      values.insert(values.end(), image.find(channel)->values.begin(), image.find(channel)->values.end());
    const auto [same, is_new] = seen.emplace(std::move(values), c.name);
    EXPECT_TRUE(is_new) << c << " is " << same->second;
  }
}

INSTANTIATE_TEST_SUITE_P(Case, Golden, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

}  // namespace
}  // namespace sideray::golden_tests
