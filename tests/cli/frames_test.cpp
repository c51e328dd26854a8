// Sequences: names, moments, stats, and what is refused.
#include <sstream>

#include "cli/program.h"
#include "scenes/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

constexpr int usage = 2;

class Frames : public Program {
 protected:
  // Without OpenGL there is nothing to draw, except where contexts are promised (script/test).
  bool can_draw() const {
    if (std::getenv("SIDERAY_REQUIRE_CONTEXTS")) return true;
    for (const json& device : json::parse(run("devices --json").output))
      if (device["usable"].get<bool>()) return true;
    return false;
  }
  void render(const std::string& arguments) {
    const Outcome outcome = run("render " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.errors, "") << "a bar is for terminals";
  }
  std::vector<float> colours(const std::string& name) const {
    const scenes::Image image = scenes::read_image(path(name));
    std::vector<float> values;
    for (const char* channel : {"R", "G", "B", "A"}) {
      const std::vector<float>& plane = image.find(channel)->values;
      values.insert(values.end(), plane.begin(), plane.end());
    }
    return values;
  }
};

TEST_F(Frames, WrongUseIsRefused) {
  const auto refused = [&](const std::string& arguments, const std::string& says) {
    expect_refused("render panes --size 32x18 " + arguments, usage, says);
  };
  refused("-o x.exr --frames 0-3", "no place for the frame's number");
  refused("-o x.#.#.exr --frames 0-3", "several runs");
  refused("-o x.#.exr --frames 3", "not A-B");
  refused("-o x.#.exr --frames 3-", "not A-B");
  refused("-o x.#.exr --frames=-3-4", "not A-B");
  refused("-o x.#.exr --frames 1-2-3", "not A-B");
  refused("-o x.#.exr --frames a-b", "--frames");
  refused("-o x.#.exr --frames 4-3", "ends before it begins");
  refused("-o x.#.exr --frames 0-3 --time 1", "--time: contradicts --frames");
  refused("-o x.#.exr --frames 0-3 --compare y.exr", "--compare: contradicts --frames");
  refused("-o x.#.exr --frames 0-3 --fps 0", "--fps");
  refused("-o x.exr --fps 25", "--fps");
  refused("-o x.#.exr --frames 0-3 --stats x.2.exr", "same file");
}

TEST_F(Frames, NumbersArePaddedAndMayGrow) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("panes --size 32x18 --frames 9-10 -o a.#.exr");
  render("panes --size 32x18 --frames 9-10 -o b###.png --stats s.jsonl");
  std::vector<std::string> names = files();
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"a.10.exr", "a.9.exr", "b009.png", "b010.png", "s.jsonl"}));
  EXPECT_EQ(colours("a.9.exr"), colours("a.10.exr")) << "nothing moves in this scene";
  std::istringstream lines(text_of(path("s.jsonl")));
  std::vector<int> frames;
  for (std::string line; std::getline(lines, line);) frames.push_back(json::parse(line)["frame"].get<int>());
  EXPECT_EQ(frames, (std::vector<int>{9, 10}));
  // Without --frames the sign is a letter like any other.
  render("panes --size 32x18 -o c#.png");
  EXPECT_TRUE(fs::exists(path("c#.png")));
}

// The moment of frame n is n / fps, cameras included; at a temporal rate the first frame is the full rate's.
TEST_F(Frames, AFrameIsThePictureOfItsMoment) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = "bistro --camera dolly --size 48x27 ";
  render(scene + "--frames 2-4 --fps 4 -o full.#.exr");
  render(scene + "--frames 2-4 --fps 4 -o quarter.#.exr --cache-rate temporal4 --stats s.jsonl");
  render(scene + "--time 0.75 -o still.exr --cache-rate temporal4");
  EXPECT_EQ(colours("full.3.exr"), colours("still.exr"));
  EXPECT_NE(colours("full.3.exr"), colours("full.4.exr")) << "the camera moves";
  EXPECT_EQ(colours("full.2.exr"), colours("quarter.2.exr"));
  EXPECT_NE(colours("full.3.exr"), colours("quarter.3.exr"));
  std::istringstream lines(text_of(path("s.jsonl")));
  std::vector<json> stats;
  for (std::string line; std::getline(lines, line);) stats.push_back(json::parse(line));
  ASSERT_EQ(stats.size(), 3u);
  EXPECT_EQ(stats[1]["config"]["time"], 0.75);
  EXPECT_EQ(stats[1]["config"]["cache-rate"], "temporal4");
  EXPECT_LT(stats[1]["rays"]["shadow"].get<double>(), 0.8 * stats[0]["rays"]["shadow"].get<double>())
      << "eleven centimetres between frames: much that was hidden is shaded anew";
}

}  // namespace
}  // namespace sideray::cli_tests
