// Tests sequences: names, times, stats, refusals, and still views.
#include <bit>
#include <cstdio>
#include <sstream>

#include "cli/glb_edit.h"
#include "cli/program.h"
#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

constexpr int usage = 2;

class Frames : public Program {
 protected:
  void render(const std::string& arguments) {
    const Outcome outcome = run("render " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.errors, "") << "a bar is for terminals";
  }
  // Makes a file of panes that the camera moves along, which is read in a tenth of the time that the bistro takes.
  std::string passed_panes() const {
    EXPECT_EQ(run("make panes -o passed.glb").exit_code, 0);
    edit_glb(path("passed.glb"), [](json& gltf) {
      const int times = accessor_of(gltf, {0, 1}, 1), places = accessor_of(gltf, {0, 0, 0, 6, 0, 0}, 3);
      gltf["accessors"][static_cast<size_t>(times)]["min"] = {0};
      gltf["accessors"][static_cast<size_t>(times)]["max"] = {1};
      const json& nodes = gltf["nodes"];
      const auto camera = std::find_if(nodes.begin(), nodes.end(), [](const json& node) { return node.contains("camera"); });
      const json sampler = {{"input", times}, {"output", places}};
      const json channel = {{"sampler", 0}, {"target", {{"node", camera - nodes.begin()}, {"path", "translation"}}}};
      gltf["animations"] = json::array({{{"samplers", json::array({sampler})}, {"channels", json::array({channel})}}});
    });
    return "passed.glb ";
  }
  // Holds the lines of a sequence's stats, and the frame of each.
  struct Lines {
    std::vector<std::string> text;
    std::vector<int> frames;
  };
  Lines lines(const std::string& name) const {
    Lines lines;
    std::istringstream text(text_of(path(name)));
    for (std::string line; std::getline(text, line); lines.text.push_back(line))
      lines.frames.push_back(json::parse(line)["frame"].get<int>());
    return lines;
  }
  void cut(const std::string& name) const { fs::resize_file(path(name), fs::file_size(path(name)) / 2); }
  std::vector<std::string> sorted_files() const {
    std::vector<std::string> names = files();
    std::sort(names.begin(), names.end());
    return names;
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
  refused("-o x.exr --shard 0/2", "--shard: a single picture is no sequence; give --frames too");
  refused("-o x.exr --warm-up 4", "--warm-up: a single picture is no sequence");
  for (const char* shard : {"1", "1/2/3", "/2", "1/", "a/2", "0/b", "-1/2", "0.5/2"})
    refused("-o x.#.exr --frames 0-3 --shard=" + std::string(shard), "--shard: ");
  refused("-o x.#.exr --frames 0-3 --shard 2/2", "--shard: 2 is out of range; give 0 to 1");
  refused("-o x.#.exr --frames 0-3 --shard 0/0", "--shard: 0 is out of range");
  refused("-o x.#.exr --frames 0-3 --warm-up few", "--warm-up");
  refused("-o x.#.exr --frames 0-3 --warm-up=-1", "--warm-up");
  refused("-o x.#.exr --frames 0-3 --stats x.2.exr", "same file");
}

TEST_F(Frames, NumbersArePaddedAndMayGrow) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("panes --size 32x18 --frames 9-10 --taa off --denoise off -o a.#.exr");
  render("panes --size 32x18 --frames 9-10 -o b###.png --stats s.jsonl");
  EXPECT_EQ(sorted_files(), (std::vector<std::string>{"a.10.exr", "a.9.exr", "b009.png", "b010.png", "s.jsonl"}));
  EXPECT_EQ(colours("a.9.exr"), colours("a.10.exr")) << "nothing moves in this scene";
  EXPECT_EQ(lines("s.jsonl").frames, (std::vector<int>{9, 10}));
  // Without --frames, "#" is an ordinary character.
  render("panes --size 32x18 -o c#.png");
  EXPECT_TRUE(fs::exists(path("c#.png")));
}

// Frame n shows the time n / fps, also of cameras.
TEST_F(Frames, AFrameIsThePictureOfItsMoment) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = passed_panes() + "--size 48x27 --shadows off --taa off --denoise off ";
  render(scene + "--frames 2-4 --fps 4 -o full.#.exr --stats s.jsonl");
  render(scene + "--time 0.75 -o still.exr");
  EXPECT_EQ(colours("full.3.exr"), colours("still.exr"));
  EXPECT_NE(colours("full.3.exr"), colours("full.4.exr")) << "the camera moves";
  std::vector<json> stats;
  for (const std::string& line : lines("s.jsonl").text) stats.push_back(json::parse(line));
  ASSERT_EQ(stats.size(), 3u);
  EXPECT_EQ(stats[1]["config"]["time"], 0.75);
}

// Smoke moves behind glass; no temporal method is on.
TEST_F(Frames, ShardsAndResumedRunsDrawTheBitsOfTheWhole) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = "smoke --size 48x27 --frames 2-6 --fps 4 --taa off --denoise off ";
  render(scene + "-o whole.#.exr");
  for (const char* shard : {"2/3", "0/3", "1/3"}) render(scene + "-o part.#.exr --shard " + shard);
  fs::copy_file(path("whole.2.exr"), path("again.2.exr"));
  fs::copy_file(path("whole.5.exr"), path("again.5.exr"));
  fs::copy_file(path("whole.6.exr"), path("again.6.exr"));
  cut("again.5.exr");
  const fs::file_time_type written = fs::last_write_time(path("again.6.exr"));
  render(scene + "-o again.#.exr --resume");
  EXPECT_EQ(fs::last_write_time(path("again.6.exr")), written) << "it was there";
  for (const std::string name : {".2.exr", ".3.exr", ".4.exr", ".5.exr", ".6.exr"}) {
    EXPECT_EQ(colours("part" + name), colours("whole" + name)) << name;
    EXPECT_EQ(colours("again" + name), colours("whole" + name)) << name;
  }
  EXPECT_NE(colours("whole.2.exr"), colours("whole.3.exr"));
}

// A skinned mesh gets new vertices, by an update far cheaper than loading the scene.
TEST_F(Frames, SkinsGetNewVertices) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene =
      SIDERAY_SOURCE_DIR "/tests/fuzz/corpus/scene/skinned.glb --size 48x27 --frames 0-3 --taa off --denoise off ";
  const auto stages = [&](const std::string& stats) {
    std::vector<json> of_frames;
    for (const std::string& line : lines(stats).text) of_frames.push_back(json::parse(line)["stages_ms"]);
    return of_frames;
  };
  render(scene + "--fps 10 -o moves.#.exr --stats moves.jsonl");
  render(scene + "--fps 10 -o part.#.exr --shard 1/2");
  render(scene + "--fps 0.5 -o still.#.exr");  // its animation takes two seconds
  EXPECT_NE(colours("moves.2.exr"), colours("moves.3.exr"));
  EXPECT_EQ(colours("part.2.exr"), colours("moves.2.exr"));
  EXPECT_EQ(colours("part.3.exr"), colours("moves.3.exr"));
  EXPECT_EQ(colours("still.2.exr"), colours("still.3.exr"));
  const std::vector<json> moves = stages("moves.jsonl");
  ASSERT_EQ(moves.size(), 4u);
  for (const size_t frame : {1, 2, 3}) {
    EXPECT_EQ(moves[frame]["load"], moves[0]["load"]) << frame;
    EXPECT_LT(moves[frame]["update"].get<double>(), 0.2 * moves[0]["load"].get<double>()) << frame;
  }
}

// So does a mesh with animated weights, beside one with constant weights.
TEST_F(Frames, MorphTargetsMove) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene =
      SIDERAY_SOURCE_DIR "/tests/fuzz/corpus/scene/morphed.gltf --size 48x27 --frames 0-3 --taa off --denoise off ";
  render(scene + "--fps 4 -o moves.#.exr --aov motion");
  render(scene + "--fps 4 -o part.#.exr --shard 1/2");
  render(scene + "--fps 0.5 -o still.#.exr --aov motion");  // its animation takes two seconds
  EXPECT_NE(colours("moves.2.exr"), colours("moves.3.exr"));
  EXPECT_EQ(colours("part.2.exr"), colours("moves.2.exr"));
  EXPECT_EQ(colours("part.3.exr"), colours("moves.3.exr"));
  EXPECT_EQ(colours("still.2.exr"), colours("still.3.exr"));
  const auto moved_pixels = [&](const std::string& name) {
    const scenes::Image image = scenes::read_image(path(name));
    const std::vector<float>& motion = image.find("motion.X")->values;
    return std::count_if(motion.begin(), motion.end(), [](float m) { return m != 0.0f; });
  };
  EXPECT_EQ(moved_pixels("still.3.exr"), 0);
  EXPECT_GT(moved_pixels("moves.3.exr"), 20);
  EXPECT_LT(moved_pixels("moves.3.exr"), 24 * 27) << "the other one stands still, as does what is behind";
}

TEST_F(Frames, AShardWritesItsBlockAlone) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = "panes --size 16x9 --frames 8-10 -o a.##.exr --stats s.jsonl ";
  const Outcome empty = run("render " + scene + "--shard 0/4");
  EXPECT_EQ(empty.exit_code, 0) << empty.errors;
  EXPECT_EQ(empty.output, "a.##.exr: the shard has no frames; nothing to draw\n");
  EXPECT_EQ(files(), std::vector<std::string>{"s.jsonl"});
  EXPECT_EQ(text_of(path("s.jsonl")), "");
  render(scene + "--shard 1/2");
  EXPECT_EQ(sorted_files(), (std::vector<std::string>{"a.09.exr", "a.10.exr", "s.jsonl"}));
  EXPECT_EQ(lines("s.jsonl").frames, (std::vector<int>{9, 10}));
  // The lines of other shards stay with --resume.
  render(scene + "--shard 0/2 --resume");
  EXPECT_EQ(lines("s.jsonl").frames, (std::vector<int>{8, 9, 10}));
}

// A block that warms up from the sequence's start has the bits of the whole; one without warming up has no history.
TEST_F(Frames, ABlockOfATemporalSequenceWarmsUp) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = passed_panes() + "--size 48x27 --frames 2-5 --fps 30 --shadows off --ambient off --taa on ";
  render(scene + "-o whole.#.exr");
  render(scene + "-o warm.#.exr --shard 1/2");
  EXPECT_FALSE(fs::exists(path("warm.3.exr"))) << "frames that warm up are not written";
  render(scene + "-o cold.#.exr --shard 1/2 --warm-up 0");
  for (const std::string name : {".4.exr", ".5.exr"})
    EXPECT_EQ(colours("warm" + name), colours("whole" + name)) << name;
  EXPECT_NE(colours("cold.4.exr"), colours("whole.4.exr"));
  // Existing frames are drawn again to warm up, but their files stay.
  fs::copy_file(path("cold.4.exr"), path("warm.2.exr"));
  fs::copy_file(path("cold.4.exr"), path("warm.3.exr"));
  fs::remove(path("warm.5.exr"));
  render(scene + "-o warm.#.exr --resume");
  EXPECT_EQ(text_of(path("warm.3.exr")), text_of(path("cold.4.exr")));
  EXPECT_EQ(colours("warm.5.exr"), colours("whole.5.exr"));
}

// Checks the table of docs/sequences.md, In parts: compares the second half of a sequence with the whole, byte by byte.
class FramesInParts : public Frames {
 protected:
  void draw_whole(const std::string& options) { render(options + size_and_frames_ + "-o whole.#.exr"); }
  // Returns whether the block has the bytes of the sequence drawn whole, else where it differs.
  testing::AssertionResult is_of_the_whole(const std::string& options, const std::string& warming) {
    render(options + size_and_frames_ + "-o part.#.exr --shard 1/2 " + warming);
    for (const std::string name : {".3.exr", ".4.exr"})
      if (text_of(path("part" + name)) != text_of(path("whole" + name)))
        return testing::AssertionFailure() << difference("part" + name, "whole" + name);
    return testing::AssertionSuccess();
  }
  // Says which pixels of two pictures differ.
  std::string difference(const std::string& part, const std::string& whole) const {
    std::ostringstream text;
    text << part;
    const scenes::Image a = scenes::read_image(path(part)), b = scenes::read_image(path(whole));
    for (const scenes::Plane& plane : a.planes) {
      const scenes::Plane* other = b.find(plane.name);
      if (!other || other->values.size() != plane.values.size()) return text.str() + ": other channels";
      size_t count = 0, first = 0;
      for (size_t i = plane.values.size(); i-- > 0;)
        if (std::bit_cast<uint32_t>(plane.values[i]) != std::bit_cast<uint32_t>(other->values[i])) first = i, ++count;
      if (count == 0) continue;
      text << "; " << plane.name << ": " << count << " pixels, the first at " << first % a.width << ' ' << first / a.width << ", "
           << plane.values[first] << " instead of " << other->values[first];
    }
    return text.str();
  }
 private:
  const std::string size_and_frames_ = " --size 32x18 --frames 2-4 --fps 60 --cull-angle 0 ";
};

TEST_F(FramesInParts, WhatHasNoPastHasTheBytesOfTheWhole) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string panes = passed_panes();
  for (const std::string& options :
       {panes + "--shadows map --ambient off --denoise on --ray-reuse 0.0625",
        panes + "--shadows map --ambient off --ray-reuse 0 --cache-rate checkerboard",
        panes + "--shadows exact --denoise off --ambient ao --reflections on",
        panes + "--translucency raytraced --shadows map --ambient off",
        std::string("'forest?count=50' --shadows inexact --denoise off")}) {
    draw_whole(options + " --taa off");
    EXPECT_TRUE(is_of_the_whole(options + " --taa off", "--warm-up 0")) << options;
  }
}

TEST_F(FramesInParts, WhatHasAPastHasThemWhereItWarmsUpFromTheFirstFrameOn) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string panes = passed_panes();
  for (const std::string& options :
       {panes + "--taa on --shadows map", panes + "--taa off --shadows exact --denoise on",
        // Panes and what is behind them see little of the sky.
        std::string("empty --taa off --shadows map --ambient ao --denoise on")}) {
    draw_whole(options);
    EXPECT_TRUE(is_of_the_whole(options, "")) << options;
    EXPECT_FALSE(is_of_the_whole(options, "--warm-up 0")) << options << ": or it has no past";
  }
}

// A still view uses the random numbers of the frame in which it came to rest. A block has the same bytes if warming up
// reaches that frame, and otherwise the same picture up to noise.
TEST_F(Frames, AStillViewInPartsIsWholeWhereItWarmsUpFromWhereItCameToRest) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string still = "solids --size 32x18 --frames 0-139 ";
  render(still + "-o whole.#.exr --stats s.jsonl");
  EXPECT_EQ(json::parse(lines("s.jsonl").text[70])["pixels"]["positions"], 64);
  render(still + "-o part.#.exr --shard 1/2 --warm-up 70");
  render(still + "-o late.#.exr --shard 1/2 --warm-up 16 --stats l.jsonl");
  for (const std::string name : {".70.exr", ".139.exr"}) EXPECT_EQ(colours("part" + name), colours("whole" + name)) << name;
  EXPECT_NE(colours("late.70.exr"), colours("whole.70.exr"));
  const Lines late = lines("l.jsonl");
  EXPECT_LT(json::parse(late.text.front())["pixels"]["positions"], 20);
  EXPECT_EQ(json::parse(late.text.back())["pixels"]["positions"], 64);
}

// Anti-aliasing over time acts from the second frame on; parts that warm up from the first frame have the bits of the
// whole.
TEST_F(Frames, ASequenceIsAntiAliasedOverTime) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = "smoke --size 48x27 --shadows map ";
  render(scene + "--frames 2-5 -o on.#.exr --stats s.jsonl");
  render(scene + "--frames 2-5 -o off.#.exr --taa off");
  render(scene + "--frames 2-5 -o part.#.exr --shard 1/2");
  render(scene + "--time 0.0666666666666667 --taa on -o alone.exr --stats s.json");
  EXPECT_EQ(json::parse(lines("s.jsonl").text[1])["config"]["taa"], "on");
  EXPECT_EQ(json::parse(text_of(path("s.json")))["config"]["taa"], "off") << "a single picture has no past";
  EXPECT_EQ(colours("on.2.exr"), colours("off.2.exr"));
  EXPECT_EQ(colours("on.2.exr"), colours("alone.exr"));
  EXPECT_NE(colours("on.3.exr"), colours("off.3.exr"));
  for (const std::string name : {".4.exr", ".5.exr"}) EXPECT_EQ(colours("part" + name), colours("on" + name)) << name;
}

TEST_F(Frames, ResumedStatsAreWholeAndInOrder) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  const std::string scene = "panes --size 16x9 --frames 0-4 -o a.#.exr --stats s.jsonl ";
  render(scene);
  const Lines first = lines("s.jsonl");
  ASSERT_EQ(first.frames, (std::vector<int>{0, 1, 2, 3, 4}));
  const std::string picture = text_of(path("a.4.exr"));
  fs::remove(path("a.1.exr"));
  // Line 3 is before line 0, line 2 is missing, line 4 is truncated.
  std::ofstream(path("s.jsonl")) << first.text[3] << "\n"
                                 << first.text[0] << "\n"
                                 << first.text[1] << "\n"
                                 << first.text[4].substr(0, 99);
  render(scene + "--resume");
  const Lines then = lines("s.jsonl");
  ASSERT_EQ(then.frames, first.frames);
  EXPECT_EQ(then.text[0], first.text[0]);
  EXPECT_NE(then.text[1], first.text[1]) << "drawn again, other times";
  EXPECT_EQ(then.text[3], first.text[3]);
  EXPECT_EQ(text_of(path("a.4.exr")), picture);
  const Outcome done = run("render " + scene + "--resume");
  EXPECT_EQ(done.output, "a.#.exr: the frames asked for exist; nothing to draw\n");
  EXPECT_EQ(lines("s.jsonl").text, then.text);
}

TEST_F(Frames, ASinglePictureThatExistsStays) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("empty --size 16x9 -o a.exr");
  render("panes --size 16x9 -o b.exr");
  fs::copy_file(path("a.exr"), path("c.exr"));
  const Outcome kept = run("render panes --size 16x9 -o a.exr --resume");
  EXPECT_EQ(kept.exit_code, 0);
  EXPECT_EQ(kept.output, "a.exr: exists; nothing to draw\n");
  EXPECT_EQ(text_of(path("a.exr")), text_of(path("c.exr")));
  // The comparison is still made.
  const Outcome compared = run("render panes --size 16x9 -o a.exr --resume --compare b.exr");
  EXPECT_EQ(compared.output, kept.output + run("compare a.exr b.exr").output);
  cut("c.exr");
  render("panes --size 16x9 -o c.exr --resume");
  EXPECT_EQ(colours("c.exr"), colours("b.exr"));
  render("panes --size 32x18 -o c.exr --resume");
  EXPECT_EQ(colours("c.exr").size(), 4u * 32 * 18) << "a picture of another size is another picture";
}

TEST_F(Frames, JobsOfVersion02AreReadAsTheyAreNow) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  std::ofstream(path("jobs.json"))
      << R"([{"o": "a.exr", "cache-rate": "temporal8", "shading-reuse": 0.5}, {"o": "b.exr", "cache-rate": "full"}])";
  const Outcome outcome = run("render panes --size 16x9 --jobs jobs.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors,
            "sideray: warning: --cache-rate temporal8: is read as full since 0.3 and refused from 0.4 on\n"
            "sideray: warning: --shading-reuse: has no effect since 0.3 and is refused from 0.4 on; leave it out\n");
  EXPECT_EQ(colours("a.exr"), colours("b.exr"));
}

TEST_F(Frames, JobsResume) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  render("empty --size 16x9 -o a.exr");
  const std::string before = text_of(path("a.exr"));
  std::ofstream(path("jobs.json")) << R"([{"o": "a.exr"}, {"o": "b.exr"}, {"o": "c.#.exr", "frames": "0-1"}])";
  const Outcome outcome = run("render panes --size 16x9 --jobs jobs.json --resume");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(text_of(path("a.exr")), before);
  EXPECT_NE(colours("b.exr"), colours("a.exr"));
  EXPECT_TRUE(fs::exists(path("c.0.exr")) && fs::exists(path("c.1.exr")));
}

// Tests a sequence in which neither camera nor scene moves, by default options.
class StillView : public Frames {
 protected:
  void draw(const std::string& arguments, int last) {
    render(arguments + " --size 48x27 --frames 0-" + std::to_string(last) + " -o x.####.exr");
  }
  scenes::Image frame(int i) const {
    char name[16];
    std::snprintf(name, sizeof(name), "x.%04d.exr", i);
    return scenes::read_image(path(name));
  }
  // In mean FLIP.
  double apart(int a, int b) const { return lab::compare(frame(a), frame(b)).metrics.flip.value_or(1); }
};

// With every option at its default.
TEST_F(StillView, BecomesThePictureOf64SamplesAndThenCostsNothing) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  for (const char* scene : {"empty", "solids"}) {
    SCOPED_TRACE(scene);
    draw(std::string(scene) + " --stats s.jsonl", 66);
    render(std::string(scene) + " --size 48x27 --samples 64 -o whole.exr");
    const std::vector<float> whole = colours("whole.exr");
    EXPECT_NE(colours("x.0063.exr"), whole);
    for (const char* frame : {"x.0064.exr", "x.0065.exr", "x.0066.exr"}) EXPECT_EQ(colours(frame), whole) << frame;
    EXPECT_LT(apart(33, 32), 0.5 * apart(5, 4));
    for (const std::string& line : lines("s.jsonl").text) {
      const json stats = json::parse(line);
      const int i = stats["frame"];
      EXPECT_EQ(stats["pixels"]["positions"], std::clamp(i, 1, 64)) << i;
      EXPECT_EQ(stats["rays"]["total"] == 0, i > 64) << i;
      EXPECT_EQ(stats["bytes"]["upload"] == 0, i > 64) << i;
    }
  }
}

// With one position in each pixel and no rough surfaces, bits stay once the masks' average over frames has converged.
TEST_F(StillView, WithoutAntiAliasingSmoothGlassSettles) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  draw("solids --taa off", 52);
  EXPECT_NE(colours("x.0040.exr"), colours("x.0041.exr")) << "or there was nothing to settle";
  for (int i = 49; i <= 52; ++i)
    EXPECT_EQ(apart(i, i - 1), 0.0) << i;
}

}  // namespace
}  // namespace sideray::cli_tests
