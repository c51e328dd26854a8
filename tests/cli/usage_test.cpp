#include <filesystem>
#include <sideray/options.h>

#include "cli/program.h"

namespace sideray::cli_tests::usage_test {
namespace {

using Usage = Program;
constexpr int failed = 1, usage = 2;

TEST_F(Usage, EveryCommandHasHelp) {
  for (const char* command : {"", "render", "bench", "compare", "info", "make", "devices", "chart", "stress", "plan", "view",
                              "golden", "golden record", "golden check", "golden approve"}) {
    const Outcome outcome = run(std::string(command) + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.output.find("Usage"), std::string::npos) << command;
    EXPECT_EQ(outcome.errors, "") << command;
  }
  EXPECT_EQ(run("--version").exit_code, 0);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Returns the switches in a help text, in their order.
std::vector<std::string> switches_of(const std::string& help) {
  std::vector<std::string> names;
  for (const std::string& line : lines_of(help))
    if (line.starts_with("  -")) names.push_back(line.substr(2, line.find(' ', 2) - 2));
  return names;
}

TEST_F(Usage, HelpOfRenderIsReadInAMinute) {
  const std::string help = run("render --help").output;
  const std::vector<std::string> lines = lines_of(help);
  EXPECT_LE(lines.size(), 100u) << "two screens of 50 lines";
  for (const std::string& line : lines) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_LE(switches_of(help).size(), 45u);
  const size_t begin = help.find("Most used:"), end = help.find("Camera and time:");
  const std::string first = help.substr(begin, end - begin);
  for (const char* name : {"-o", "--size", "--camera", "--frames", "--quality", "--translucency", "--layers",
                           "--samples", "--reference", "--stats"})
    EXPECT_NE(first.find("\n  " + std::string(name) + " "), std::string::npos) << name << first;
  EXPECT_NE(help.find("--diagnose NAME=VALUE"), std::string::npos);
}

// The program reads every option of the table, as a switch or by --diagnose.
TEST_F(Usage, TheLongHelpAndTheDiagnosticsAreTheWholeTable) {
  const std::vector<std::string> brief = switches_of(run("render --help").output),
                                 all = switches_of(run("render --help-all").output);
  EXPECT_LT(brief.size(), all.size());
  for (const std::string& name : brief) EXPECT_NE(std::find(all.begin(), all.end(), name), all.end()) << name;
  const std::string diagnostics = run("render --diagnose help").output;
  EXPECT_EQ(run("render --diagnose list").output, diagnostics);
  for (size_t i = 0; i < sideray_option_count(); ++i) {
    const sideray_option& option = *sideray_option_at(i);
    const bool has_switch = std::find(all.begin(), all.end(), "--" + std::string(option.name)) != all.end();
    EXPECT_EQ(has_switch, option.diagnostic == 0) << option.name;
    const bool is_listed = ("\n" + diagnostics).find("\n" + std::string(option.name) + "=") != std::string::npos;
    EXPECT_EQ(is_listed, option.diagnostic != 0) << option.name;
    EXPECT_STRNE(option.group, "") << option.name;
  }
  for (const std::string& line : lines_of(diagnostics)) EXPECT_LE(line.size(), 110u) << line;
}

TEST_F(Usage, DiagnosticsAreChecked) {
  const std::string render = "render panes -o x.png --diagnose ";
  expect_refused(render + "matching=id", usage, "--diagnose: unknown name \"matching\"; one of second-wave");
  expect_refused(render + "match=plane", usage, "--diagnose match: unknown value \"plane\"; one of id, nearest");
  expect_refused(render + "match", usage, "write match=id|nearest|distance");
  expect_refused(render + "match=", usage, "--diagnose match");
  expect_refused(render + "match-threshold=0", usage, "--diagnose match-threshold: 0 is out of range");
  expect_refused(render + "step=retrace --diagnose match=id,step=listing", usage, "step is given twice");
  expect_refused(render + "check=maybe", usage, "give true or false");
  expect_refused("plan panes --diagnose check", usage, "unknown name \"check\"");
  expect_refused(render + "whole-pixels=on --mask none", usage,
                 "--diagnose whole-pixels=on: no mask counts the surfaces of pixels, so that none is known to be whole; leave --mask out");
}

TEST_F(Usage, RemovedSwitchesSayWhatToWrite) {
  for (const char* command : {"render panes -o x.png", "plan panes", "chart panes -o d", "bench panes"}) {
    expect_refused(command + std::string(" --match distance"), usage,
                   "--match: is gone since 0.3; write --diagnose match=id|nearest|distance");
    expect_refused(command + std::string(" --second-wave=off"), usage, "write --diagnose second-wave=on|off");
  }
  expect_refused("render panes -o x.png --stats s.json --check", usage, "write --diagnose check=true");
  expect_refused("render panes -o x.png --stats s.json --repeat 3", usage, "use sideray bench SCENE --repeat N");
  expect_refused("render panes -o x.png --raw-frame", usage, "use sideray bench");
  for (const char* option : {"--map m.png", "--fail-above 1", "--fail-below 1", "--metric psnr", "--json"})
    expect_refused("render panes -o x.png --compare a.png " + std::string(option), usage, "use sideray compare");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png", "repeat": 3}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json job 0: --repeat: is gone since 0.3; use sideray bench");
}

TEST_F(Usage, MappedSwitchesSayWhatTheyAre) {
  // Without OpenGL nothing is measured, which would take seconds.
  const std::string no_gl = "SIDERAY_CACHE=off __EGL_VENDOR_LIBRARY_DIRS=/none __EGL_VENDOR_LIBRARY_FILENAMES=/none";
  const Outcome now = run("plan panes --gl egl --cache-rate full", no_gl),
                then = run("plan panes --gl egl --cache-rate temporal4 --shading-reuse=0.25", no_gl);
  EXPECT_EQ(then.exit_code, 0);
  EXPECT_EQ(then.output, now.output);
  EXPECT_EQ(then.errors,
            "sideray: warning: --cache-rate temporal4: is read as full since 0.3 and refused from 0.4 on\n"
            "sideray: warning: --shading-reuse: has no effect since 0.3 and is refused from 0.4 on; leave it out\n" + now.errors);
  EXPECT_EQ(run("render --help-all").output.find("shading-reuse"), std::string::npos);
  EXPECT_EQ(run("render --help-all").output.find("temporal4"), std::string::npos);
}

TEST_F(Usage, WrongUsageIsExitCodeTwo) {
  expect_refused("", usage, "no command");
  expect_refused("paint", usage, "paint");
  expect_refused("render panes -o x.png --colour red", usage, "--colour");
  expect_refused("render panes", usage, "-o");
  expect_refused("render -o x.png", usage, "no scene");
  expect_refused("render panes -o x.gif", usage, ".exr or .png");
  expect_refused("render panes -o x", usage, ".exr or .png");
  expect_refused("render panes -o x.png --gl vulkan", usage, "auto, egl, osmesa");
  expect_refused("render panes -o x.png --translucency thick", usage, "raytraced");
  expect_refused("render panes -o x.png --seed 1 --seed 2", usage, "--seed");
  expect_refused("compare x.png", usage, "REFERENCE");
  expect_refused("info", usage, "SCENE");
  expect_refused("make panes -o x.gltf", usage, ".glb");
  expect_refused("make nothing -o x.glb", usage, "panes");
  expect_refused("make panes -o x.glb --set count", usage, "K=V");
  expect_refused("make panes -o x.glb --set colour=3", usage, "count");
  expect_refused("make panes -o x.glb --set count=many", usage, "many");
  expect_refused("make panes -o x.glb --set count=2 --set count=3", usage, "count is given twice");
}

TEST_F(Usage, MistypedNamesAreAnsweredWithTheNearest) {
  expect_refused("render panes -o x.png --shadow exact", usage,
                 "sideray: --shadow: no such option; did you mean --shadows? see sideray render --help");
  expect_refused("render panes --colour=red -o x.png", usage,
                 "sideray: --colour: no such option; see sideray render --help");
  expect_refused("rendr panes -o x.png", usage, "sideray: rendr: no such command; did you mean render? see sideray --help");
  expect_refused("golden recrod d", usage,
                 "sideray: recrod: no such command; did you mean record? see sideray golden --help");
  expect_refused("render panes solids -o x.png", usage,
                 "sideray: solids: one argument too many; see sideray render --help");
  expect_refused("render panes -o x.png --thread 2", usage, "did you mean --threads?");
  expect_refused("render panes -o x.png --shading-reus 1", usage, "no such option; see");  // --shading-reuse has no effect
}

TEST_F(Usage, ValuesAreChecked) {
  for (const char* size :
       {"0x5", "5x0", "-5x5", "16385x1", "99999999999999999999x5", "16384x16384", "12", "axb", "5x", "5x5x5", "5.5x5"})
    expect_refused("render panes -o x.png --size " + std::string(size), usage, "--size");
  expect_refused("render panes -o x.png --layers 9", usage, "0 to 8");
  expect_refused("render panes -o x.png --layers unlimited", usage, "--layers");
  expect_refused("render panes -o x.png --translucency raytraced --layers 0", usage, "1 to 64");
  expect_refused("render panes -o x.png --translucency raytraced --layers auto", usage, "--layers");
  expect_refused("render panes -o x.png --samples 0", usage, "--samples");
  expect_refused("render panes -o x.png --threads 0", usage, "--threads");
  expect_refused("render panes -o x.png --seed -1", usage, "--seed");
  expect_refused("render panes -o x.png --exposure nan", usage, "--exposure");
  expect_refused("render panes -o x.png --env-scale inf", usage, "--env-scale");
  expect_refused("render panes -o x.png --env clouds", usage, "--env");
  expect_refused("render panes -o x.png --eye 0,0,0", usage, "--target");
  expect_refused("render panes -o x.png --eye 0,0,0 --target 0,0,0", usage, "another point");
  expect_refused("render panes -o x.png --eye 0,0 --target 0,0,1", usage, "--eye");
  expect_refused("render panes -o x.png --eye 0,0,1 --target 0,0,0 --camera 0", usage, "--camera");
  expect_refused("render panes -o x.png --fov 40", usage, "--fov");
  expect_refused("render panes -o x.png --eye 0,0,1 --target 0,0,0 --fov 180", usage, "--fov");
  for (const char* wrong : {"30,30,16", "30,30,16,9,0", "0,30,16,9", "30,-30,16,9", "30,30,nan,9", "30,1e-3,16,9",
                            "30,1e-2,16,9", "30,30,1e6,9", "30,30,16,1e6"})
    expect_refused(std::string("render panes -o x.png --size 32x18 --intrinsics ") + wrong, usage, "--intrinsics");
  expect_refused("render panes -o x.png --intrinsics 30,30,16,9 --eye 0,0,1 --target 0,0,0 --fov 40", usage, "--fov");
  expect_refused("render panes -o x.png --camera nobody", usage, "nobody");
  expect_refused("render panes -o x.png --camera 99", usage, "99");
  expect_refused("render panes -o x.png --ray-traced 'nothing*'", usage, "nothing*");
  expect_refused("render panes -o x.png", usage, "SIDERAY_ISA", "SIDERAY_ISA=mmx");
}

TEST_F(Usage, AovsAreChecked) {
  expect_refused("render panes -o x.png --aov Z", usage, ".exr");
  expect_refused("render panes -o x.exr --aov depth", usage, "unknown name");
  expect_refused("render panes -o x.exr --aov N.W", usage, "unknown name");
  expect_refused("render panes -o x.exr --shadows map --aov mask.inexact", usage, "--shadows inexact");
  expect_refused("render panes -o x.exr --shadows map --aov shadow.sun", usage, "no shadow masks");
  expect_refused("render panes -o x.exr --aov layer4", usage, "layers 0 to 3");
  expect_refused("render panes -o x.exr --aov layers --translucency raster", usage, "no layers");
}

TEST_F(Usage, WindowsAreRefusedBeforeTheyOpen) {
  const bool is_built = std::filesystem::exists(std::string(SIDERAY_BINARY_DIR) + "/sideray-view");
  expect_refused("view no_such_scene", usage, is_built ? "no_such_scene" : "libglfw3-dev");
  expect_refused("view", usage, is_built ? "view: no scene" : "libimgui-dev");
  expect_refused("view panes --layers 99", usage, is_built ? "--layers" : "libglfw3-dev");
  expect_refused("view panes --samples 4", usage, "--samples");
}

TEST_F(Usage, BoundsAreChecked) {
  expect_refused("render panes -o x.png --max-ms 0", usage, "--max-ms");
  expect_refused("render panes -o x.png --max-error 1.5", usage, "--max-error");
  expect_refused("render panes -o x.png --max-error 0.1 --reference", usage, "--max-error");
  expect_refused("plan panes --max-ms 5 --translucency reference", usage, "nothing to choose");
  expect_refused("chart panes -o d --max-ms 5", usage, "--max-ms");
}

TEST_F(Usage, SetsOfValuesAreChosenOnce) {
  expect_refused("render panes -o x.png --quality good", usage, "draft, balanced, best");
  expect_refused("render panes -o x.png --quality best --max-ms 5", usage, "--quality: contradicts --max-ms");
  expect_refused("plan panes --quality balanced --max-error 0.1", usage, "--quality: contradicts --max-error");
  expect_refused("render panes -o x.png --quality draft --reference", usage, "contradicts --quality");
}

TEST_F(Usage, OldPosesAreAnsweredWithTheNew) {
  expect_refused("render panes -o x.png --foliage static", usage, "poses rest");
  expect_refused("render panes -o x.png --shared-copies 4", usage, "poses K");
  expect_refused("render panes -o x.png --unique-cap none", usage, "poses all");
}

TEST_F(Usage, ChecksNeedSomethingToCheck) {
  expect_refused("render panes -o x.png --diagnose check", usage, "--stats");
  for (const std::string mode : {"--translucency raytraced", "--translucency raster", "--reference"})
    expect_refused("render panes -o x.png --stats s.json --diagnose check=true " + mode, usage, "only hybrid");
}

TEST_F(Usage, BenchmarksAreChecked) {
  expect_refused("bench", usage, "no scene");
  expect_refused("bench panes --repeat 0", usage, "--repeat");
  expect_refused("bench panes --max-ms 10", usage, "--max-ms");
  expect_refused("bench panes --json nosuch/s.json", failed, "nosuch/s.json");
  expect_refused("bench panes -o x.exr --json x.exr", usage, "same file");
  expect_refused("bench panes --frames 0-1 -o x.exr", usage, "#");
}

TEST_F(Usage, AReferenceIsNotToldWhatItDecides) {
  for (const char* option :
       {"--translucency raster", "--ray-traced all", "--layers 4", "--mask none", "--shadows map", "--oit sorted",
        "--cache-rate full", "--diagnose match=id", "--diagnose step=multihit", "--poses rest"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find_last_of(" ="));
    expect_refused("render panes -o x.png --reference " + std::string(option), usage, "contradicts " + name);
  }
  expect_refused("render panes -o x.png --light-samples 8", usage, "--reference or --translucency reference");
  expect_refused("render panes -o x.png --reference --light-samples 0", usage, "out of range");
  expect_refused("render panes -o x.exr --reference --aov mask", usage, "neither mask nor layers");
  expect_refused("render panes -o x.exr --reference --aov motion", usage, "nor motion");
  expect_refused("render panes -o x.#.exr --frames 0-1 --taa on --samples 2", usage, "averages already");
  expect_refused("render panes -o x.exr --reference --aov layer0", usage, "neither mask nor layers");
}

TEST_F(Usage, AnimationsThatDoNotExistAreNamed) {
  expect_refused("render panes -o x.png --animation walk", usage, "no animation walk");
  expect_refused("render panes -o x.png --time -1", usage, "--time");
  expect_refused("render panes -o x.png --time soon", usage, "--time");
}

TEST_F(Usage, BoundsFitTheirMetric) {
  expect_refused("compare a.png b.png --fail-above 1 --metric psnr", usage, "--fail-below");
  expect_refused("compare a.png b.png --fail-below 1 --metric flip", usage, "--fail-above");
  expect_refused("compare a.png b.png --metric beauty", usage, "relmse_trimmed");
  expect_refused("compare a.png b.png --map m.exr", usage, ".png");
}

TEST_F(Usage, BadInputIsOneLine) {
  expect_refused("render nosuch.glb -o x.png", failed, "nosuch.glb");
  expect_refused("info nosuch.gltf", failed, "nosuch.gltf");
  for (const char* command : {"render nosuch -o x.png", "info nosuch", "make nosuch -o x.glb"})
    expect_refused(command, usage, "nosuch");
  expect_refused("compare nosuch.png nosuch.png", failed, "nosuch.png");
  expect_refused("render panes -o nosuch/x.png", failed, "nosuch/x.png");
  expect_refused("render panes -o x.png --stats nosuch/s.json", failed, "nosuch/s.json");
  expect_refused("render panes -o x.png --env nosuch.exr", failed, "nosuch.exr");
  std::ofstream(path("tiny.hdr"), std::ios::binary) << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"
                                                    << std::string(4, '\x80');
  expect_refused("render panes -o x.png --env tiny.hdr", failed, "cannot use tiny.hdr: environment of 1x1 pixels; ");
  expect_refused("make panes -o nosuch/x.glb", failed, "nosuch/x.glb");
  fs::create_directory(path("folder.png"));
  expect_refused("render panes -o folder.png", failed, "it is a folder; choose another name");
  expect_refused("render panes -o " + std::string(252, 'x') + ".png", failed, "choose a shorter name");
}

TEST_F(Usage, AFileBeyondTheShellsLimitIsOneLine) {
  const std::string blocks = "ulimit -f 8 &&";  // of 512 bytes
  expect_refused("make panes -o x.glb", failed, "File too large; free some space", blocks);
}

TEST_F(Usage, BrokenSceneFilesAreOneLine) {
  ASSERT_EQ(run("make panes -o whole.glb").exit_code, 0);
  const std::string whole = text_of(path("whole.glb"));
  for (size_t length : {size_t{0}, size_t{11}, size_t{40}, whole.size() / 2, whole.size() - 1}) {
    std::ofstream(path("cut.glb"), std::ios::binary) << whole.substr(0, length);
    expect_refused("render cut.glb -o x.png", failed, "cut.glb");
  }
  std::ofstream(path("noise.glb"), std::ios::binary) << "\x8f\x01 noise \xff\x7f";
  expect_refused("info noise.glb", failed, "cannot read noise.glb: it is neither binary glTF nor JSON; ");
  std::ofstream(path("strange.gltf")) << R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[]}],"scene":0,)"
                                      << R"("extensionsUsed":["ACME_magic"],"extensionsRequired":["ACME_magic"]})";
  expect_refused("render strange.gltf -o x.png", failed, "ACME_magic");
}

TEST_F(Usage, FilesAreKeptApart) {
  expect_refused("render panes -o x.exr --compare ./x.exr", usage, "same file");
  expect_refused("render panes -o x.exr --stats x.exr", usage, "same file");
  expect_refused("render panes -o x.exr --env x.exr", usage, "same file");
  expect_refused("render p.glb -o x.exr --stats p.glb", usage, "same file");
  expect_refused("compare a.png b.png --map a.png", usage, "same file");
  expect_refused("render panes -o x.png --stats -", usage, "standard output");
  expect_refused("render panes -o x.png --stats /dev/null", failed, "not a regular file");
}

TEST_F(Usage, EmptyAndUnfitValuesAreRefused) {
  for (const char* option : {"--camera", "--device", "--compare", "--stats"})
    expect_refused("render panes -o x.png " + std::string(option) + " ''", usage, "empty");
  expect_refused("render panes -o x.png --size 64x", usage, "WIDTHxHEIGHT");
}

TEST_F(Usage, JobsFilesAreChecked) {
  fs::create_directory(path("folder"));
  expect_refused("render --jobs folder", failed, "folder");
  std::ofstream(path("jobs.json")) << "[{]";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: is not JSON");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png", "o": "b.png"}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: \"o\" is given twice");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png", "exposure": 1e400}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: holds a number that no double holds");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a\u0000b.png"}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json job 0: o holds a NUL");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png"}, {"scene": "panes", "o": "./a.png"}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json job 1: writes ./a.png as job 0 does");
  std::ofstream(path("jobs.json")) << R"([{"scene": "nosuch.glb", "o": "a.png"}])";
  expect_refused("render --jobs jobs.json", failed, "jobs.json job 0");
  std::ofstream(path("jobs.json")) << "[]";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: holds no job");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png", "shadow": "exact"}])";
  expect_refused("render --jobs jobs.json", usage, "job 0: --shadow: no such option; did you mean --shadows?");
}

TEST_F(Usage, AFullStandardOutputFails) {
  // The comment sign hides the redirection that run() adds.
  const Outcome outcome = run("make --list >/dev/full 2>stderr.txt #");
  EXPECT_EQ(outcome.exit_code, failed);
  EXPECT_TRUE(outcome.errors.starts_with("sideray: standard output: ")) << outcome.errors;
  // The output is longer than the buffer.
  const Outcome plan = run("plan panes --size 16x16 --json >/dev/full 2>stderr.txt #");
  EXPECT_EQ(plan.exit_code, failed);
  EXPECT_NE(plan.errors.find("sideray: standard output: "), std::string::npos) << plan.errors;
}

TEST_F(Usage, NamesThatAreNotUtf8AreReplacedInJson) {
  ASSERT_EQ(run("make panes -o '\xff.glb'").exit_code, 0);
  const std::string scene = "'\xff.glb' --size 8x8 --gl none";
  for (const char* command : {"plan --json ", "bench --repeat 1 --json - "})
    EXPECT_TRUE(nlohmann::json::accept(run(command + scene).output)) << command;
  const Outcome drawn = run("render " + scene + " --frames 0-1 --shard 0/1 -o '\xff.##.png' --stats '\xff.json'");
  EXPECT_EQ(drawn.exit_code, 0) << drawn.errors;
}

TEST_F(Usage, NoDeviceIsOneLine) {
  const std::string nowhere = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json __EGL_VENDOR_LIBRARY_DIRS=/nonexistent";
  expect_refused("render panes -o x.png --gl egl --size 16x16", failed, "no usable OpenGL device", nowhere);
  expect_refused("render panes -o x.png --device nosuch --size 16x16", usage, "nosuch");
}

}  // namespace
}  // namespace sideray::cli_tests::usage_test
