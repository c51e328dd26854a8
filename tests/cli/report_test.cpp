#include <limits>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;
using Report = Program;

const std::string data = SIDERAY_SOURCE_DIR "/tests/lab/data/";

TEST_F(Report, CompareGivesTheMetrics) {
  const Outcome display = run("compare " + data + "order_a.png " + data + "order_b.png --json");
  ASSERT_EQ(display.exit_code, 0) << display.errors;
  const json metrics = json::parse(display.output);
  EXPECT_NEAR(metrics["flip"].get<double>(), 0.030804, 2e-5);
  EXPECT_FALSE(metrics.contains("hdr_flip"));
  EXPECT_EQ(metrics["nonfinite"], 0);
  const Outcome linear = run("compare " + data + "hdr_b.exr " + data + "hdr_a.exr --json");
  EXPECT_NEAR(json::parse(linear.output)["hdr_flip"].get<double>(), 0.196514, 2e-5);
}

TEST_F(Report, CompareKeepsTheBound) {
  const std::string pair = "compare " + data + "order_a.png " + data + "order_b.png ";
  EXPECT_EQ(run(pair + "--fail-above 0.04").exit_code, 0);
  EXPECT_EQ(run(pair + "--fail-above 0.03").exit_code, 1);
  EXPECT_EQ(run(pair + "--fail-below 32 --metric psnr").exit_code, 0);
  EXPECT_EQ(run(pair + "--fail-below 33 --metric psnr").exit_code, 1);
  EXPECT_EQ(run(pair + "--fail-above 1 --metric hdr_flip").exit_code, 2);
  EXPECT_EQ(run("compare " + data + "order_a.png " + data + "hdr_a.exr").exit_code, 2);
}

// Compares radiance with display values, by the metrics of PNG values alone.
TEST_F(Report, CompareMeetsBothKinds) {
  scenes::Image image{16, 12, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::half, std::vector<float>(16 * 12, 0.25f), {}});
  scenes::write_exr(path("a.exr"), image);
  scenes::write_png(path("a.png"), 16, 12,
                    scenes::quantize(scenes::display_values(image, 0, scenes::Tonemap::pbr_neutral)));
  const json metrics = json::parse(run("compare a.png a.exr --json").output);
  EXPECT_LT(metrics["flip"].get<double>(), 0.02) << "half a step of eight bits on a flat field";
  EXPECT_GT(metrics["psnr"].get<double>(), 50);
  for (const char* name : {"relmse", "relmse_trimmed", "hdr_flip"}) EXPECT_FALSE(metrics.contains(name)) << name;
  EXPECT_EQ(run("compare a.png a.exr --metric relmse --fail-above 1").exit_code, 2);
}

TEST_F(Report, CompareFailsWithPixelsThatAreNotFinite) {
  scenes::Image image{16, 12, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::half, std::vector<float>(16 * 12, 0.5f), {}});
  image.planes[1].values[5] = std::numeric_limits<float>::quiet_NaN();
  scenes::write_exr(path("nan.exr"), image);
  const Outcome outcome = run("compare nan.exr nan.exr --json --map m.png");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(json::parse(outcome.output), json({{"nonfinite", 1}}));
  EXPECT_EQ(outcome.error_lines(), 1u);
  EXPECT_NE(outcome.errors.find("not finite"), std::string::npos) << outcome.errors;
  EXPECT_FALSE(fs::exists(path("m.png")));
}

TEST_F(Report, CompareWritesAMap) {
  ASSERT_EQ(run("compare " + data + "order_a.png " + data + "order_b.png --map m.png").exit_code, 0);
  const scenes::Image map = scenes::read_image(path("m.png"));
  EXPECT_EQ(map.width, 320u);
  EXPECT_EQ(map.height, 180u);
  const scenes::Plane& red = *map.find("R");
  EXPECT_LT(*std::min_element(red.values.begin(), red.values.end()), 0.05f);
  EXPECT_GT(*std::max_element(red.values.begin(), red.values.end()), 0.5f);
}

TEST_F(Report, InfoIsJson) {
  const Outcome outcome = run("info panes --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const json info = json::parse(outcome.output);
  for (const char* key :
       {"scene", "cameras", "lights", "animations", "materials", "extensions", "defaulted", "warnings"})
    EXPECT_TRUE(info.contains(key)) << key;
  EXPECT_FALSE(run("info panes").output.empty());
}

TEST_F(Report, MakeIsDeterministicAndLists) {
  ASSERT_EQ(run("make panes -o a.glb --set count=3 --set gap=0.1").exit_code, 0);
  ASSERT_EQ(run("make panes -o b.glb --set gap=0.1 --set count=3").exit_code, 0);
  EXPECT_EQ(text_of(path("a.glb")), text_of(path("b.glb")));
  const std::string list = run("make --list").output;
  for (const char* name : {"bistro", "panes", "solids", "empty", "count", "gap", "angle", "distance"})
    EXPECT_NE(list.find(name), std::string::npos) << name;
}

TEST_F(Report, DevicesSayWhy) {
  const json devices = json::parse(run("devices --json").output);
  ASSERT_TRUE(devices.is_array());
  for (const json& device : devices) {
    for (const char* key : {"id", "gl", "usable", "reason"}) ASSERT_TRUE(device.contains(key)) << key;
    EXPECT_NE(device["usable"].get<bool>(), !device["reason"].get<std::string>().empty());
  }
  const json none = json::parse(run("devices --json", "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json").output);
  for (const json& device : none)
    if (device["gl"] == "egl") {
      EXPECT_FALSE(device["usable"].get<bool>());
    }
  EXPECT_EQ(run("devices").exit_code, 0);
}

}  // namespace
}  // namespace sideray::cli_tests
