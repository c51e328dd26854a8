// Tests references in a folder: recording, checking and approving them, as in CI.
#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <map>

#include "cli/glb_edit.h"
#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests::golden_test {
namespace {

using nlohmann::json;

constexpr int equal = 0, failed = 1, wrong_usage = 2, differs = 3;

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Golden : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    ASSERT_EQ(run("make solids -o s.glb").exit_code, 0);
    write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.png", "size": "48x27"},
                             {"scene": "s.glb", "o": "sub/b.exr", "size": "32x18", "aov": "N"}])");
  }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name)) << text;
  }
  Outcome golden(const std::string& arguments, int exit_code, const std::string& environment = "") const {
    const Outcome outcome = run("golden " + arguments, environment);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.output << outcome.errors;
    return outcome;
  }
  void record() const { golden("record d", equal); }
  void edit(const std::function<void(json& gltf)>& change) const { edit_glb(path("s.glb"), change); }
  void move_ball() const {
    edit([](json& gltf) { node_named(gltf, "ball")["matrix"][12] = node_named(gltf, "ball")["matrix"][12].get<double>() + 0.3; });
  }

  // Returns all files below a folder with their bytes.
  std::map<std::string, std::string> content(const std::string& folder) const {
    std::map<std::string, std::string> files;
    if (!fs::exists(path(folder))) return files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path(folder)))
      if (entry.is_regular_file()) files[entry.path().lexically_relative(path(folder)).string()] = text_of(entry.path());
    return files;
  }
  json manifest() const { return json::parse(text_of(path("d/references/manifest.json"))); }
};

TEST_F(Golden, WhatIsUnchangedIsEqualForAnyNumberOfThreads) {
  const Outcome recorded = golden("record d --threads 2", equal);
  EXPECT_EQ(recorded.output, "a: recorded\nsub/b: recorded\n");
  EXPECT_EQ(recorded.errors, "");
  const auto references = content("d/references");
  EXPECT_EQ(references.size(), 5u);
  const Outcome outcome = golden("check d --threads 1", equal);
  EXPECT_EQ(outcome.output, "a: equal\nsub/b: equal\n2 of 2 pictures are as recorded\n");
  EXPECT_EQ(outcome.errors, "");
  EXPECT_EQ(content("d/references"), references);
  EXPECT_EQ(manifest()["pictures"][0]["driver"], "rays alone");
  // The pictures are those of render, and ids those of --aov.
  ASSERT_EQ(run("render s.glb --gl none --size 32x18 -o b.exr --aov N,first.surface").exit_code, 0);
  const scenes::Image drawn = scenes::read_image(path("b.exr")), kept = scenes::read_image(path("d/references/sub/b.exr")),
                      ids = scenes::read_image(path("d/references/sub/b.ids.exr"));
  for (const char* name : {"R", "A", "N.X"}) EXPECT_EQ(drawn.find(name)->values, kept.find(name)->values) << name;
  EXPECT_EQ(drawn.find("first.surface")->uint_values, ids.find("first.surface")->uint_values);
  EXPECT_EQ(kept.find("first.surface"), nullptr);
}

TEST_F(Golden, TheObjectThatMovedIsNamed) {
  record();
  move_ball();
  const Outcome outcome = golden("check d --junit j.xml --page p.html", differs);
  EXPECT_TRUE(outcome.output.starts_with("a: 'ball' moved (")) << outcome.output;
  EXPECT_TRUE(has(outcome.output, "\nsub/b: 'ball' moved (")) << outcome.output;
  EXPECT_TRUE(has(outcome.output, "2 of 2 pictures differ; look at p.html")) << outcome.output;
  const std::string junit = text_of(path("j.xml")), page = text_of(path("p.html"));
  EXPECT_TRUE(has(junit, "<testsuites tests=\"2\" failures=\"2\"")) << junit;
  EXPECT_TRUE(has(junit, "name=\"sub/b\"") && has(junit, "<failure message=\"'ball' moved")) << junit;
  EXPECT_TRUE(has(page, "'ball' moved")) << "the page lists no change";
  EXPECT_TRUE(has(page, "\"reference\":\"data:image/png;base64,") && has(page, "\"map\":\"data:image/png;base64,"));
  for (const char* outside : {"src=\"http", "href=\"http", "<link rel=\"stylesheet"}) EXPECT_FALSE(has(page, outside));
}

TEST_F(Golden, WhatIsGoneComesOrLooksOtherwiseIsNamed) {
  record();
  const std::string whole = text_of(path("s.glb"));
  edit([](json& gltf) { node_named(gltf, "cube").erase("mesh"); });
  EXPECT_TRUE(golden("check d", differs).output.starts_with("a: 'cube' is missing (")) << "gone";
  golden("approve d", equal);
  golden("check d", equal);
  std::ofstream(path("s.glb"), std::ios::binary) << whole;
  EXPECT_TRUE(golden("check d", differs).output.starts_with("a: 'cube' appears (")) << "come";
  golden("approve d", equal);
  edit([](json& gltf) {
    const json& mesh = gltf["meshes"][node_named(gltf, "wall")["mesh"].get<size_t>()];
    gltf["materials"][mesh["primitives"][0]["material"].get<size_t>()]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 0, 0, 1};
  });
  EXPECT_TRUE(golden("check d", differs).output.starts_with("a: 'wall' looks otherwise (FLIP 0.")) << "painted";
}

TEST_F(Golden, ADarkerLightIsOneLine) {
  write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.exr", "size": "48x27", "env": "none", "reflections": "off"},
                           {"scene": "s.glb", "o": "b.png", "size": "48x27", "env": "none"}])");
  record();
  edit([](json& gltf) {
    for (json& light : gltf["extensions"]["KHR_lights_punctual"]["lights"])
      light["intensity"] = 0.98 * light.value("intensity", 1.0);
  });
  const Outcome outcome = golden("check d", differs);
  EXPECT_TRUE(outcome.output.starts_with("a: the light is 0.98 times as bright everywhere\nb: the light is 0.98")) << outcome.output;
}

TEST_F(Golden, FramesOfASequenceArePicturesOfTheirOwn) {
  write("d/jobs.json", R"([{"scene": "haze", "o": "h.##.png", "frames": "3-5", "fps": 4, "size": "48x27"}])");
  EXPECT_EQ(golden("record d", equal).output, "h.03: recorded\nh.04: recorded\nh.05: recorded\n");
  ASSERT_EQ(run("render haze --gl none --frames 3-5 --fps 4 --size 48x27 -o h.##.png").exit_code, 0);
  for (const char* name : {"h.03.png", "h.04.png", "h.05.png"})
    EXPECT_EQ(text_of(path(name)), text_of(path(std::string("d/references/") + name))) << name;
  golden("check d", equal);
}

TEST_F(Golden, PicturesAreApprovedByNameOrAll) {
  record();
  const auto before = content("d/references");
  move_ball();
  golden("check d", differs);
  EXPECT_EQ(content("d/references"), before);
  expect_refused("golden approve d nosuch", wrong_usage, "nosuch: no picture of that name differed");
  EXPECT_EQ(golden("approve d sub/b", equal).output, "sub/b: approved\n");
  auto after = content("d/references");
  EXPECT_EQ(after["a.png"], before.at("a.png"));
  EXPECT_NE(after["sub/b.exr"], before.at("sub/b.exr"));
  const Outcome again = golden("check d", differs);
  EXPECT_TRUE(has(again.output, "sub/b: equal\n1 of 2 pictures differ")) << again.output;
  EXPECT_EQ(golden("approve d", equal).output, "a: approved\n");
  golden("check d", equal);
  EXPECT_EQ(golden("approve d", equal).output, "d: nothing differed in the last check\n");
}

TEST_F(Golden, RecordingAgainSaysWhatIsAnotherPicture) {
  record();
  write("d/references/.gitattributes", "*.exr filter=lfs\n");
  EXPECT_EQ(golden("record d", equal).output, "a: recorded, the same as before\nsub/b: recorded, the same as before\n");
  move_ball();
  write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.png", "size": "48x27"}])");
  EXPECT_EQ(golden("record d", equal).output, "a: recorded; differs from the reference before\n");
  // Obsolete references are removed, files of the user stay.
  EXPECT_EQ(content("d/references").count("sub/b.exr"), 0u);
  EXPECT_EQ(content("d/references")[".gitattributes"], "*.exr filter=lfs\n");
}

TEST_F(Golden, OptionsOfTheCommandLineAreRecorded) {
  write("jobs/list.json", R"([{"scene": "s.glb", "o": "a.png"}])");
  golden("record d --jobs jobs/list.json --size 20x10 --threads 1 --seed 3", equal);
  EXPECT_EQ(manifest()["options"], (json{{"gl", "none"}, {"size", "20x10"}, {"seed", "3"}}));
  EXPECT_EQ(manifest()["jobs_file"], "../jobs/list.json");
  EXPECT_EQ(manifest()["pictures"][0]["width"], 20);
  golden("check d", equal);
}

// Names with any characters stay data in XML, in the page and in the terminal.
TEST_F(Golden, NamesAreEscaped) {
  record();
  edit([](json& gltf) {
    node_named(gltf, "ball")["name"] = "<b a=\"1\">&\n</script>";
    node_named(gltf, "cube").erase("mesh");
  });
  const Outcome outcome = golden("check d --junit j.xml", differs);
  EXPECT_TRUE(has(outcome.output, "'<b a=\"1\">& </script>' appears")) << outcome.output;
  const std::string junit = text_of(path("j.xml")), page = text_of(path("d/check.html"));
  EXPECT_TRUE(has(junit, "'&lt;b a=&quot;1&quot;&gt;&amp; &lt;/script&gt;' appears")) << junit;
  EXPECT_FALSE(has(junit, "<b ") || has(page, "<b a="));
  EXPECT_TRUE(has(page, "\\u003cb a=\\\"1\\\">"));
}

TEST_F(Golden, AnotherDriverDiffersAsFarAsWasApproved) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.png", "size": "48x27", "gl": "auto"}])");
  record();
  const std::string picture = text_of(path("d/references/a.png"));
  golden("check d", equal);
  const std::string by_rays = "SIDERAY_GL=none";
  EXPECT_TRUE(has(golden("check d", differs, by_rays).output, "; drawn by rays alone, recorded by "));
  EXPECT_TRUE(has(golden("approve d", equal).output, "a: rays alone may differ by FLIP "));
  EXPECT_EQ(text_of(path("d/references/a.png")), picture);
  const json drift = manifest()["pictures"][0]["drift"]["rays alone"];
  EXPECT_GT(drift["flip"], 0.0);
  EXPECT_GT(drift["share"], 0.0);
  EXPECT_TRUE(golden("check d", equal, by_rays).output.starts_with("a: within the drift of rays alone"));
  golden("check d", equal);
  // A tenth of the drift is below the approved amount.
  json less = manifest();
  less["pictures"][0]["drift"]["rays alone"]["flip"] = 0.1 * drift["flip"].get<double>();
  std::ofstream(path("d/references/manifest.json")) << less;
  EXPECT_TRUE(has(golden("check d", differs, by_rays).output, "more than was approved for it"));
  // Even a slight motion of an object is never accepted as a driver's difference.
  move_ball();
  golden("check d", differs, by_rays);
  expect_refused("golden approve d", wrong_usage, "objects differ, not the driver");
}

TEST_F(Golden, WhatCannotBeHeldStillIsRefused) {
  const auto refused = [&](const std::string& jobs, const std::string& says) {
    write("d/jobs.json", jobs);
    expect_refused("golden record d", wrong_usage, says);
    EXPECT_FALSE(fs::exists(path("d/references")));
  };
  for (const char* option : {"max-ms", "max-error", "budget", "deadline"})
    refused(R"([{"scene": "panes", "o": "a.png", ")" + std::string(option) + R"(": 1}])", "cannot be held still");
  refused(R"([{"scene": "panes", "o": "../a.png"}])", "job 0: o ../a.png: is no name inside");
  refused(R"([{"scene": "panes", "o": "/tmp/a.png"}])", "is no name inside");
  refused(R"([{"scene": "panes", "o": "a.png"}, {"scene": "panes", "o": "a.exr"}])", "job 1: writes a.ids.exr as");
  refused(R"([{"scene": "panes", "o": "a.png"}, {"scene": "panes", "o": "a.ids.exr"}])", "job 1: writes a.ids.exr as");
  refused("[]", "holds no job");
  refused(R"([{"scene": "panes", "o": "a.png", "layers": 99}])", "job 0: --layers");
  expect_refused("golden record d --jobs nosuch.json", failed, "nosuch.json");
  expect_refused("golden record nosuch", failed, "nosuch/jobs.json");
  expect_refused("golden record d --stats s.json", wrong_usage, "--stats");
  expect_refused("golden", wrong_usage, "subcommand");
}

TEST_F(Golden, WhatAKilledProgramLeftIsRemovedAndWhatARunningOneHasIsNot) {
  for (const char* name : {"references.tmp-a1B2c3", "references.tmp-d4E5f6", "check.tmp-a1B2c3", "mine.tmp-a1B2c3"})
    write("d/" + std::string(name) + "/half.png", "half");
  const int running = ::open(path("d/references.tmp-d4E5f6").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(running, LOCK_EX | LOCK_NB), 0);
  record();
  ::close(running);
  EXPECT_FALSE(fs::exists(path("d/references.tmp-a1B2c3")));
  for (const char* name : {"references.tmp-d4E5f6", "check.tmp-a1B2c3", "mine.tmp-a1B2c3"})
    EXPECT_TRUE(fs::exists(path("d/" + std::string(name)) + "/half.png")) << name;
}

TEST_F(Golden, WhatIsDamagedIsNamedAndStaysAsItIs) {
  record();
  const std::string references = path("d/references");
  const auto broken = [&](const std::function<void()>& damage, const std::string& says, const std::string& command = "check d") {
    fs::copy(path("d"), path("whole"), fs::copy_options::recursive);
    damage();
    const auto before = content("d");
    expect_refused("golden " + command, failed, says);
    EXPECT_EQ(content("d"), before) << says;
    fs::remove_all(path("d"));
    fs::rename(path("whole"), path("d"));
  };
  const std::string manifest_file = references + "/manifest.json", text = text_of(manifest_file);
  for (const char* command : {"check d", "record d", "approve d"}) {
    broken([&] { std::ofstream(manifest_file) << "{\"schema\": 2}"; }, "is of version 2, this program reads 1", command);
    broken([&] { std::ofstream(manifest_file) << text.substr(0, text.size() / 2); }, "manifest.json: is not a manifest", command);
    broken([&] { std::ofstream(manifest_file) << R"({"schema": 1, "pictures": 3})"; }, "manifest.json: is not a manifest", command);
  }
  broken([&] { fs::remove(references + "/a.png"); }, "references/a.png: is missing; restore it, or record again");
  broken([&] { fs::remove(references + "/sub/b.ids.exr"); }, "b.ids.exr");
  broken([&] { fs::resize_file(references + "/sub/b.exr", 200); }, "b.exr");
  broken([&] { (void)run("render panes --gl none --size 48x27 -o d/references/a.png"); }, "a.png: is not the picture that was recorded");
  broken([&] { (void)run("render panes --gl none --size 24x27 -o d/references/a.png"); }, "a.png: is 24x27, recorded were 48x27");
  broken([&] { fs::remove(path("d/jobs.json")); }, "d/jobs.json");
  broken([&] { write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.png"}])"); }, "d/jobs.json: is not what was recorded");
  broken([&] { fs::remove_all(references); }, "d: holds no references");
  broken([&] { fs::create_directory(path("d/check")); }, "d/check: is not of a check");
  broken([&] {
    fs::remove_all(references);
    write("d/references/mine.txt", "");
  }, "d/references: holds other files", "record d");
  json fewer = manifest();
  fewer["pictures"].erase(1);
  broken([&] { std::ofstream(manifest_file) << fewer; }, "its pictures are not those of its jobs");
  broken([&] {}, "d: has no check to approve", "approve d");
  expect_refused("golden check nosuch", failed, "nosuch: is no folder");
  expect_refused("golden check s.glb", failed, "s.glb: is no folder");
  expect_refused("golden check d --junit nosuch/j.xml", failed, "nosuch/j.xml");
  expect_refused("golden check d --junit d/references", wrong_usage, "--junit");
  expect_refused("golden check d --page x.html --junit x.xml --threads 0", wrong_usage, "--threads");
}

TEST_F(Golden, ApprovalIsOfTheReferencesThatWereChecked) {
  record();
  move_ball();
  golden("check d", differs);
  fs::remove(path("d/check/a.png"));
  expect_refused("golden approve d", failed, "d/check/a.png");
  golden("record d", equal);
  expect_refused("golden approve d", failed, "was checked against other references");
}

#if defined(SIDERAY_FAILING_CALLS)
// Simulates a full disk at every place in turn: all references are the old ones, or all are the new ones.
class GoldenFaults : public Golden {
 protected:
  struct Counts {
    uint64_t allocations = 0, files = 0, failures = 0;
  };

  void SetUp() override {
    Golden::SetUp();
    write("d/jobs.json", R"([{"scene": "s.glb", "o": "a.png", "size": "16x9"}, {"scene": "s.glb", "o": "b.exr", "size": "16x9"}])");
    record();
    move_ball();
    golden("check d", differs);
    fs::rename(path("d"), path("before"));
  }

  Outcome fault(const std::string& command, const std::string& which, const std::string& more = "") {
    fs::remove_all(path("d"));
    fs::copy(path("before"), path("d"), fs::copy_options::recursive);
    const Outcome outcome = run("golden " + command + " d", more + " LD_PRELOAD='" SIDERAY_FAILING_CALLS "' SIDERAY_FAULT=" + which +
                                                                " SIDERAY_FAULT_COUNT='" + path("count") + "'");
    std::ifstream(path("count"), std::ios::binary).read(reinterpret_cast<char*>(&counts_), sizeof(counts_));
    return outcome;
  }

  // Fails at all places of file calls in turn, or at `most` evenly spread ones.
  void places(const std::string& command, int exit_code, uint64_t most = UINT64_MAX) {
    const auto old = content("before/references");
    EXPECT_EQ(fault(command, "none").exit_code, exit_code);
    const auto made = content("d/references");
    const uint64_t all = counts_.files, number = std::min(all, most);
    EXPECT_GT(all, 15u);
    for (uint64_t i = 0; i < number; ++i) {
      // Fails once, or permanently.
      const std::string which = "file:" + std::to_string(1 + (2 * i + 1) * all / (2 * number)) + (i % 2 ? "+" : "");
      SCOPED_TRACE(command + " " + which);
      const Outcome outcome = fault(command, which);
      EXPECT_TRUE(outcome.exit_code == failed || outcome.exit_code == exit_code) << outcome.exit_code << outcome.errors;
      if (outcome.exit_code == failed) {
        EXPECT_EQ(outcome.error_lines(), 1u) << outcome.errors;
      }
      const auto now = content("d/references");
      EXPECT_TRUE(now == old || now == made) << now.size() << " files";
      if (outcome.exit_code == exit_code) {
        EXPECT_TRUE(now == made);
      }
      for (const auto& entry : content("d")) EXPECT_FALSE(has(entry.first, ".tmp-")) << entry.first;
    }
  }

  Counts counts_;
};

TEST_F(GoldenFaults, Record) {
  places("record", equal, 5);
}
TEST_F(GoldenFaults, Check) {
  places("check", differs, 5);
}
TEST_F(GoldenFaults, Approve) {
  places("approve", equal, 12);
}
TEST_F(GoldenFaults, FoldersThatCannotBeExchangedAreRenamed) {
  const auto old = content("before/references");
  EXPECT_EQ(fault("approve", "none", "SIDERAY_NO_EXCHANGE=1").exit_code, equal);
  EXPECT_NE(content("d/references"), old);
  for (const fs::directory_entry& entry : fs::directory_iterator(path("d")))
    EXPECT_FALSE(has(entry.path().filename().string(), ".tmp-")) << entry.path();
  golden("check d", equal);
}

class SlowGoldenFaults : public GoldenFaults {};
TEST_F(SlowGoldenFaults, EveryPlaceOfRecord) {
  places("record", equal);
}
TEST_F(SlowGoldenFaults, EveryPlaceOfCheck) {
  places("check", differs);
}
TEST_F(SlowGoldenFaults, EveryPlaceOfApprove) {
  places("approve", equal);
}
#endif

}  // namespace
}  // namespace sideray::cli_tests::golden_test
