#include "cli/program.h"

namespace sideray::cli_tests::usage_test {
namespace {

using Usage = Program;
constexpr int failed = 1, usage = 2;

TEST_F(Usage, EveryCommandHasHelp) {
  for (const char* command : {"", "render", "compare", "info", "make", "devices", "chart", "stress", "plan"}) {
    const Outcome outcome = run(std::string(command) + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.output.find("Usage"), std::string::npos) << command;
    EXPECT_EQ(outcome.errors, "") << command;
  }
  EXPECT_EQ(run("--version").exit_code, 0);
}

TEST_F(Usage, HelpNamesEveryOptionOfRender) {
  const std::string help = run("render --help").output;
  for (const char* option : {"size",
                             "camera",
                             "eye",
                             "target",
                             "fov",
                             "gl",
                             "device",
                             "quality",
                             "translucency",
                             "ray-traced",
                             "layers",
                             "cache-rate",
                             "second-wave",
                             "whole-pixels",
                             "match",
                             "match-threshold",
                             "step",
                             "mask",
                             "refraction",
                             "rt-particles",
                             "oit",
                             "shadows",
                             "inexact",
                             "inexact-bias",
                             "inexact-target",
                             "poses",
                             "cull-angle",
                             "reflections",
                             "ao",
                             "denoise",
                             "taa",
                             "samples",
                             "light-samples",
                             "frames",
                             "fps",
                             "time",
                             "animation",
                             "threads",
                             "seed",
                             "deadline",
                             "max-ms",
                             "max-error",
                             "env",
                             "env-scale",
                             "env-rotate",
                             "default-light",
                             "exposure",
                             "tonemap",
                             "reference",
                             "aov",
                             "truth",
                             "stats",
                             "check",
                             "repeat",
                             "jobs",
                             "shard",
                             "resume",
                             "warm-up",
                             "compare",
                             "map",
                             "fail-above",
                             "fail-below",
                             "metric",
                             "json"})
    EXPECT_NE(help.find("  --" + std::string(option)), std::string::npos) << option;
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

TEST_F(Usage, WhatIsNotBuiltIsRefused) {
  expect_refused("view panes", usage, "view");
  EXPECT_EQ(run("--help").output.find("view"), std::string::npos) << "what does not exist is not offered";
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

TEST_F(Usage, MatchingIsChecked) {
  expect_refused("render panes -o x.png --match-threshold 0", usage, "out of range");
  expect_refused("render panes -o x.png --match plane", usage, "plane");
  expect_refused("render panes -o x.png --check", usage, "--stats");
  expect_refused("render panes -o x.png --raw-frame", usage, "--stats");
  expect_refused("render panes -o x.#.png --stats s.json --raw-frame --frames 0-1", usage, "--frames");
  expect_refused("render panes -o x.png --stats s.json --raw-frame --max-ms 10", usage, "bound");
  for (const char* mode : {"--translucency raytraced", "--translucency raster", "--reference"})
    expect_refused("render panes -o x.png --stats s.json --check " + std::string(mode), usage, "only hybrid");
}

TEST_F(Usage, AReferenceIsNotToldWhatItDecides) {
  for (const char* option :
       {"--translucency raster", "--ray-traced all", "--layers 4", "--mask none", "--shadows map", "--oit sorted",
        "--cache-rate full", "--match id", "--step multihit", "--poses rest"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
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
  expect_refused("render panes -o x.png --fail-above 1", usage, "--compare");
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
  expect_refused("render panes -o folder.png", failed, "folder");
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
  for (const char* option : {"--camera", "--device", "--compare", "--stats", "--map"})
    expect_refused("render panes -o x.png " + std::string(option) + " ''", usage, "empty");
  expect_refused("render panes -o x.png --compare r.exr --metric hdr_flip --fail-above 1", usage, "hdr_flip");
  expect_refused("render panes -o x.png --size 10x20 --compare r.png --metric ssim --fail-below 1", usage, "ssim");
  expect_refused("render panes -o x.png --size 64x", usage, "WIDTHxHEIGHT");
}

TEST_F(Usage, JobsFilesAreChecked) {
  fs::create_directory(path("folder"));
  expect_refused("render --jobs folder", failed, "folder");
  std::ofstream(path("jobs.json")) << "[{]";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: is not JSON");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png", "o": "b.png"}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: \"o\" is given twice");
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png"}, {"scene": "panes", "o": "./a.png"}])";
  expect_refused("render --jobs jobs.json", usage, "jobs.json job 1: writes ./a.png as job 0 does");
  std::ofstream(path("jobs.json")) << R"([{"scene": "nosuch.glb", "o": "a.png"}])";
  expect_refused("render --jobs jobs.json", failed, "jobs.json job 0");
  std::ofstream(path("jobs.json")) << "[]";
  expect_refused("render --jobs jobs.json", usage, "jobs.json: holds no job");
}

TEST_F(Usage, AFullStandardOutputFails) {
  // The comment sign hides the redirection that run() adds.
  const Outcome outcome = run("make --list >/dev/full 2>stderr.txt #");
  EXPECT_EQ(outcome.exit_code, failed);
  EXPECT_TRUE(outcome.errors.starts_with("sideray: standard output: ")) << outcome.errors;
  // Longer than what is buffered.
  const Outcome plan = run("plan panes --size 16x16 --json >/dev/full 2>stderr.txt #");
  EXPECT_EQ(plan.exit_code, failed);
  EXPECT_NE(plan.errors.find("sideray: standard output: "), std::string::npos) << plan.errors;
}

TEST_F(Usage, NoDeviceIsOneLine) {
  const std::string nowhere = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json __EGL_VENDOR_LIBRARY_DIRS=/nonexistent";
  expect_refused("render panes -o x.png --gl egl --size 16x16", failed, "no usable OpenGL device", nowhere);
  expect_refused("render panes -o x.png --device nosuch --size 16x16", usage, "nosuch");
}

}  // namespace
}  // namespace sideray::cli_tests::usage_test
