// Tests that the files of --truth and the channels of ground truth agree.
#include <set>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class Truth : public Program {
 protected:
  void render(const std::string& arguments) const {
    const Outcome outcome = run("render " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << outcome.errors;
  }
  json truth(const std::string& name) const { return json::parse(text_of(path(name))); }
};

std::vector<bool> decoded_counts(const json& mask) {
  const size_t height = mask["size"][0], width = mask["size"][1];
  std::vector<bool> pixels(width * height);
  size_t at = 0;
  bool inside = false;
  for (const size_t run : mask["counts"]) {
    for (size_t k = 0; k < run; ++k, ++at) pixels.at(at % height * width + at / height) = inside;
    inside = !inside;
  }
  EXPECT_EQ(at, pixels.size());
  return pixels;
}

// A part of a picture has the whole's lens and its own principal point.
TEST_F(Truth, APartOfACalibratedPictureIsThatPart) {
  render("solids -o whole.exr --size 48x32 --gl none --aov first --truth whole.json --intrinsics 40,30,22.5,17.25 --stats s.json");
  EXPECT_EQ(json::parse(text_of(path("s.json")))["config"]["intrinsics"], "40,30,22.5,17.25");
  const json k = truth("whole.json")["images"][0]["camera"]["K"];
  const std::array<double, 9> wanted{40, 0, 22.5, 0, 30, 17.25, 0, 0, 1};
  for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(k[i].get<double>(), wanted[i], 1e-4) << i;
  constexpr size_t left = 11, top = 5, width = 24, height = 16;
  render("solids -o part.exr --size 24x16 --gl none --aov first --intrinsics 40,30,11.5,12.25");
  const scenes::Image whole = scenes::read_image(path("whole.exr")), part = scenes::read_image(path("part.exr"));
  const std::vector<uint32_t>&in_whole = whole.find("first.surface")->uint_values,
        &in_part = part.find("first.surface")->uint_values;
  size_t differ = 0;
  std::set<uint32_t> seen;
  for (size_t i = 0; i < in_part.size(); ++i) {
    seen.insert(in_part[i]);
    differ += in_part[i] != in_whole[(top + i / width) * whole.width + left + i % width];
  }
  EXPECT_EQ(in_part.size(), width * height);
  EXPECT_LE(differ, 2u) << "an edge may fall beside a pixel's middle";
  EXPECT_GE(seen.size(), 3u) << "nothing to see in the part";
}

// The lens options also apply to cameras that an animation moves or that a file gives.
TEST_F(Truth, AFlightKeepsItsLens) {
  render("'bistro?tables=1' -o f.####.png --frames 0-2 --size 16x9 --gl none --camera dolly --translucency off --shadows off "
         "--intrinsics 12,14,9,3 --truth t.####.json");
  for (const char* file : {"t.0000.json", "t.0002.json"})
    EXPECT_NEAR(truth(file)["images"][0]["camera"]["K"][2].get<double>(), 9.0, 1e-4) << file;
  EXPECT_NE(truth("t.0000.json")["images"][0]["camera"]["world_from_camera"],
            truth("t.0002.json")["images"][0]["camera"]["world_from_camera"]);
}

TEST_F(Truth, MasksAreThoseOfTheChannels) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("solids -o x.exr --size 64x36 --aov first,refraction.state --truth x.json");
  const scenes::Image image = scenes::read_image(path("x.exr"));
  const json file = truth("x.json");
  EXPECT_EQ(file["images"][0]["file_name"], "x.exr");
  EXPECT_EQ(file["images"][0]["width"], 64);
  EXPECT_NEAR(file["images"][0]["camera"]["K"][2].get<double>(), 32.0, 0.0);
  EXPECT_EQ(file["images"][0]["camera"]["K"][0], file["images"][0]["camera"]["K"][4]);
  const std::vector<uint32_t>& first = image.find("first.surface")->uint_values;
  size_t seen = 0, translucent = 0;
  for (const json& annotation : file["annotations"]) {
    const std::set<uint32_t> surfaces = annotation["surfaces"];
    const std::vector<bool> visible = decoded_counts(annotation["segmentation"]),
                            amodal = decoded_counts(annotation["amodal_segmentation"]);
    size_t area = 0, whole = 0;
    for (size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(visible[i], surfaces.contains(first[i])) << annotation["name"] << ' ' << i;
      if (visible[i]) {
        EXPECT_TRUE(amodal[i]);
      }
      area += visible[i], whole += amodal[i];
    }
    EXPECT_EQ(annotation["area"], area);
    EXPECT_EQ(annotation["amodal_area"], whole);
    const double coverage = annotation["coverage"], fraction = annotation["visible_fraction"];
    EXPECT_NEAR(coverage, static_cast<double>(whole), 0.2 * static_cast<double>(whole) + 8);
    EXPECT_LE(fraction, 1.0);
    EXPECT_GE(fraction, 0.0);
    seen += area;
    translucent += annotation["category_id"] == 2;
  }
  EXPECT_EQ(seen, static_cast<size_t>(std::count_if(first.begin(), first.end(), [](uint32_t id) { return id != 0; })));
  EXPECT_GE(translucent, 4u);
  EXPECT_EQ(file["categories"].size(), 2u);
}

TEST_F(Truth, PartsOfGroupsAreChosenAndKeptWhole) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("panes -o x.exr --size 32x18 --aov glass.N,behind.Z,refraction.state");
  const scenes::Image image = scenes::read_image(path("x.exr"));
  std::vector<std::string> names;
  for (const scenes::Plane& plane : image.planes) names.push_back(plane.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"A", "B", "G", "R", "behind.Z", "glass.N.X", "glass.N.Y", "glass.N.Z",
                                             "refraction.state"}));
  EXPECT_EQ(image.find("glass.N.X")->type, scenes::Plane::Type::single);
  EXPECT_EQ(image.find("behind.Z")->type, scenes::Plane::Type::single);
  EXPECT_EQ(image.find("refraction.state")->type, scenes::Plane::Type::uint);
  expect_refused("render panes -o x.exr --aov glass.length", 2, "unknown name");
  expect_refused("render panes -o x.exr --aov refraction.Z", 2, "unknown name");
}

TEST_F(Truth, SequencesHaveAFileAFrame) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene =
      SIDERAY_SOURCE_DIR "/tests/fuzz/corpus/scene/morphed.gltf --size 48x27 --frames 0-2 --fps 4 --taa off ";
  render(scene + "-o m.#.exr --truth m.#.json");
  const json first = truth("m.0.json"), last = truth("m.2.json");
  EXPECT_EQ(last["images"][0]["id"], 2);
  EXPECT_EQ(last["images"][0]["file_name"], "m.2.exr");
  EXPECT_NE(first["annotations"], last["annotations"]);
  // A missing file is made again, with the same content.
  const std::string before = text_of(path("m.1.json"));
  fs::remove(path("m.1.json"));
  render(scene + "-o m.#.exr --truth m.#.json --resume");
  EXPECT_EQ(text_of(path("m.1.json")), before);
  expect_refused("render " + scene + "-o x.#.exr --truth x.json", 2, "--truth x.json: has no place");
  expect_refused("render panes -o x.exr --truth x.txt", 2, "--truth");
  expect_refused("render panes -o x.exr --truth s.json --stats s.json", 2, "--truth");
}

}  // namespace
}  // namespace sideray::cli_tests
