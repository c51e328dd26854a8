// Tests that golden cases without OpenGL have the bits recorded in rays_alone.json on every machine, for any
// instruction set, C library and number of cores. SIDERAY_UPDATE_GOLDEN records them. tests/CMakeLists.txt runs this
// for several instruction sets.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "cli/program.h"
#include "scenes/base/files.h"
#include "scenes/images/images.h"

namespace sideray::golden_tests {
namespace {

namespace fs = std::filesystem;
using cli_tests::text_of;
using nlohmann::json;
using nlohmann::ordered_json;

const fs::path list = SIDERAY_SOURCE_DIR "/tests/golden/rays_alone.json";

// Hashes values, not files, whose compression depends on a library.
std::string digest_of(const scenes::Image& image) {
  uint64_t hash = scenes::empty_hash;
  const auto add = [&hash](const void* bytes, size_t size) {
    hash = scenes::hash_of({static_cast<const uint8_t*>(bytes), size}, hash);
  };
  for (const scenes::Plane& plane : image.planes) {
    add(plane.name.c_str(), plane.name.size() + 1);
    add(plane.values.data(), plane.values.size() * sizeof(float));
    add(plane.uint_values.data(), plane.uint_values.size() * sizeof(uint32_t));
  }
  return fmt::format("{}x{} {:016x}", image.width, image.height, hash);
}

bool can_run(std::string_view isa) {
#if defined(__x86_64__)
  if (isa == "avx2") return __builtin_cpu_supports("avx2");
  if (isa == "avx512") return __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
#endif
  return isa.empty() || isa == "sse4.2";
}

TEST(RaysAloneDigests, AreThoseThatWereRecorded) {
  const char* isa = std::getenv("SIDERAY_ISA");
  if (!can_run(isa ? isa : "")) GTEST_SKIP() << "this processor has no " << isa;
  // Several of these run at once.
  const fs::path folder = fs::path(testing::TempDir()) / fmt::format("sideray_rays_alone_{}", getpid());
  fs::create_directories(folder);
  ordered_json found = ordered_json::object();
  for (const json& c : json::parse(text_of(list.parent_path() / "cases.json"))) {
    const std::string options = c.at("options"), name = c.at("name");
    const unsigned frames = c.value("frames", 0u);
    const std::string command = fmt::format(
        "cd '" SIDERAY_SOURCE_DIR "/tests/golden' && '" SIDERAY_BINARY_DIR "/sideray' render {} --size 96x54 {} --gl none -o '{}'{}", c.at("scene").get<std::string>(),
        options, (folder / (frames > 0 ? "picture.####.exr" : "picture.exr")).string(),
        frames > 0 ? fmt::format(" --frames 0-{}", frames - 1) : "");
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const fs::path picture = folder / (frames > 0 ? fmt::format("picture.{:04}.exr", frames - 1) : "picture.exr");
    found[name] = digest_of(scenes::read_image(picture.string()));
  }
  fs::remove_all(folder);
  if (std::getenv("SIDERAY_UPDATE_GOLDEN")) {
    std::ofstream(list) << found.dump(1) << "\n";
    return;
  }
  const json recorded = json::parse(text_of(list));
  EXPECT_EQ(found.size(), recorded.size());
  for (const auto& [name, digest] : found.items())
    EXPECT_EQ(digest, recorded.value(name, "none"))
        << name << ": where the picture was meant to change, SIDERAY_UPDATE_GOLDEN=1 build/test_golden "
        << "--gtest_filter='RaysAloneDigests.*' records it";
}

}  // namespace
}  // namespace sideray::golden_tests
