#include <gmock/gmock.h>
#include <sideray/scenes.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "scenes/images/images.h"
#include "scenes/support.h"

// Tests small files that ask for much memory or time, with lowered limits instead of large files.
namespace sideray::scenes::bombs_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<uint8_t> corpus_picture(const std::string& name) {
  return bytes_of(std::string(SIDERAY_SOURCE_DIR) + "/tests/fuzz/corpus/picture/" + name);
}

std::string error_within(SmallGltf& g, const ReadLimits& limits) {
  const ScratchFolder folder;
  const std::string path = g.write(folder);
  LoadOptions options;
  options.limits = limits;
  const std::string message = message_of([&] { load_file(path, options); });
  EXPECT_TRUE(message.empty() || message.find(path) != std::string::npos) << message << " does not name the file";
  return message;
}

size_t add_without_data(SmallGltf& g, const char* type, size_t count) {
  g.json["accessors"].push_back({{"componentType", 5126}, {"type", type}, {"count", count}});
  return g.json["accessors"].size() - 1;
}

struct Bomb {
  const char* name;
  std::function<void(SmallGltf&)> fill;
  const char* thing;  // as the error names it
};

void PrintTo(const Bomb& bomb, std::ostream* out) { *out << bomb.name; }

// Each asks for more than 0.7 MB, which are left of 1.9 MB after the least that JSON and nodes take.
const Bomb bombs[] = {
    {"Accessor", [](SmallGltf& g) { g.primitive()["attributes"]["POSITION"] = add_without_data(g, "VEC3", 200000); },
     "mesh tri, POSITION"},
    {"Attributes",
     [](SmallGltf& g) {
       g.primitive()["attributes"]["POSITION"] = add_without_data(g, "VEC3", 30000);
       g.primitive()["attributes"]["COLOR_0"] = add_without_data(g, "VEC4", 30000);
     },
     "mesh tri, COLOR_0"},
    {"Strip",
     [](SmallGltf& g) {
       g.primitive()["attributes"]["POSITION"] = add_without_data(g, "VEC3", 30000);
       g.primitive()["mode"] = 5;
     },
     "mesh tri, triangles"},
    {"Keys",
     [](SmallGltf& g) {
       const size_t times = add_without_data(g, "SCALAR", 40000), values = add_without_data(g, "VEC3", 40000);
       g.json["animations"] = {{{"samplers", {{{"input", times}, {"output", values}}}},
                                {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
     },
     "animation animation0, channel 0, values"},
    {"Instances",
     [](SmallGltf& g) {
       g.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
           add_without_data(g, "VEC3", 20000);
     },
     "node a"},
    {"Targets",
     [](SmallGltf& g) {
       const size_t zeros = add_without_data(g, "VEC3", 10000);
       g.primitive()["attributes"]["POSITION"] = zeros;
       g.primitive()["targets"] = json::array();
       for (int i = 0; i < 20; ++i) g.primitive()["targets"].push_back({{"POSITION", zeros}});
     },
     "mesh tri, target"},
    {"Nodes",
     [](SmallGltf& g) {
       for (int i = 1; i < 3000; ++i) {
         g.json["nodes"].push_back(json::object());
         g.json["scenes"][0]["nodes"].push_back(i);
       }
     },
     "its nodes"},
    {"Values", [](SmallGltf& g) { g.json["extras"] = std::vector<int>(9000, 0); }, "its JSON"},
    {"Sprites",
     [](SmallGltf& g) {
       g.json["nodes"][0]["extras"]["sideray"]["particles"] = {{"count", 50000}, {"lifetime", 1}, {"size", 1}};
     },
     "particles of node a"},
    {"Texels",
     [](SmallGltf& g) {
       // Of the picture only the size is looked at before memory is asked for.
       std::vector<uint8_t> png = corpus_picture("p8.png");
       const uint8_t side[] = {0, 0, 4, 0, 0, 0, 4, 0};
       std::memcpy(&png[16], side, 8);
       // The header has changed, and so has its check sum (CRC-32), which libpng looks at.
       uint32_t crc = 0xffffffffu;
       for (size_t i = 12; i < 29; ++i) {
         crc ^= png[i];
         for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
       }
       crc = ~crc;
       for (size_t i = 0; i < 4; ++i) png[29 + i] = static_cast<uint8_t>(crc >> (24 - 8 * i));
       g.json["images"] = {{{"bufferView", g.add_view(png)}, {"mimeType", "image/png"}}};
       g.json["textures"] = {{{"source", 0}}};
       g.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
       g.primitive()["material"] = 0;
     },
     "image 0"}};

class Bombs : public testing::TestWithParam<Bomb> {};

TEST_P(Bombs, AreRefusedBeforeTheyTakeMemory) {
  SmallGltf g;
  GetParam().fill(g);
  EXPECT_THAT(error_within(g, {.seconds = 20, .bytes = 1'900'000}),
              AllOf(HasSubstr(GetParam().thing), HasSubstr("more than the 0.0019 GB"),
                    HasSubstr("; allow more with SIDERAY_LOAD_GB")));
  if (GetParam().thing == std::string("image 0")) return;
  EXPECT_EQ(error_within(g, {.seconds = 20, .bytes = 200'000'000}), "");
}

TEST_P(Bombs, AreRefusedWhenTheTimeIsOver) {
  SmallGltf g;
  GetParam().fill(g);
  EXPECT_THAT(error_within(g, {.seconds = 1e-9, .bytes = 200'000'000}),
              AllOf(HasSubstr("it takes longer than 1e-09 s"), HasSubstr("; allow more time with SIDERAY_LOAD_SECONDS")));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Bombs, testing::ValuesIn(bombs),
                         [](const auto& of) { return std::string(of.param.name); });

struct Variable {
  explicit Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() { ::unsetenv(name_); }
  const char* name_;
};

TEST(Limits, AreTheEnvironmentsWhereNoneAreGiven) {
  SmallGltf g;
  {
    const Variable small("SIDERAY_LOAD_GB", "0.0001"), time("SIDERAY_LOAD_SECONDS", "60");
    EXPECT_THAT(error_within(g, {}), HasSubstr("needs more than the 0.0001 GB of memory"));
    EXPECT_EQ(error_within(g, {.seconds = 0, .bytes = 100'000'000}), "") << "what is given goes before";
  }
  {
    const Variable time("SIDERAY_LOAD_SECONDS", "1e-9");
    EXPECT_THAT(error_within(g, {}), HasSubstr("it takes longer than 1e-09 s"));
  }
  for (const char* odd : {"many", "-1", "0", "1x", "nan", "1e30"}) {
    const Variable variable("SIDERAY_LOAD_GB", odd);
    const ScratchFolder folder;
    const std::string path = g.write(folder);
    EXPECT_THAT(message_of([&] { load_file(path); }),
                AllOf(HasSubstr("SIDERAY_LOAD_GB: "), HasSubstr(odd), HasSubstr("; ")));
  }
  EXPECT_EQ(error_within(g, {}), "");
}

TEST(Limits, AreGivenThroughTheCInterface) {
  SmallGltf g;
  const ScratchFolder folder;
  const std::string path = g.write(folder);
  sideray_load_options options;
  sideray_load_init(&options, sizeof(options));
  EXPECT_EQ(options.max_seconds, 0.0);
  EXPECT_EQ(options.max_bytes, 0u);
  options.max_bytes = 1000;
  sideray_content* content = nullptr;
  sideray_error error{};
  EXPECT_EQ(sideray_content_load(path.c_str(), &options, &content, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr(path), HasSubstr("of memory that reading may take")));
  // A caller that was compiled before the limits came has the defaults.
  options.size = offsetof(sideray_load_options, max_seconds);
  EXPECT_EQ(sideray_content_load(path.c_str(), &options, &content, &error), SIDERAY_OK) << error.message;
  sideray_content_release(content);
}

// A changed picture of the corpus: 16384 a side, with so many starts of scans behind its own.
std::vector<uint8_t> jpeg_with_scans(size_t scans) {
  std::vector<uint8_t> bytes = corpus_picture("a.jpg");
  for (size_t i = 0; i + 8 < bytes.size(); ++i) {
    if (bytes[i] != 0xff || (bytes[i + 1] != 0xc0 && bytes[i + 1] != 0xc2)) continue;
    bytes[i + 5] = bytes[i + 7] = 0x40, bytes[i + 6] = bytes[i + 8] = 0;
    break;
  }
  for (size_t i = 0; i < scans; ++i) bytes.insert(bytes.end() - 2, {0xff, 0xda});
  return bytes;
}

TEST(Pictures, OfTooManyScansAreRefused) {
  EXPECT_THAT(message_of([] { decode_image(jpeg_with_scans(17), "a.jpg"); }),
              AllOf(HasSubstr("a.jpg: its "), HasSubstr("scans go over 16384 x 16384 pixels too often; ")));
}

TEST(Pictures, GivenByThemselvesAreRefusedBeforeTheyTakeMemory) {
  const ScratchFolder folder;
  const std::string hdr = "#?RADIANCE\n\n-Y 16384 +X 16384\n";
  put_bytes(folder / "a.hdr", std::span(reinterpret_cast<const uint8_t*>(hdr.data()), hdr.size()));
  EXPECT_THAT(message_of([&] { read_image(folder / "a.hdr"); }), HasSubstr("3 channels of 16384 x 16384 pixels"));
}

// Makes names unique by the rule itself: lights without a name or with a shared one get their own, until none is
// shared.
std::vector<std::string> unique_names(std::vector<std::string> names) {
  for (bool changed = true; changed;) {
    changed = false;
    std::map<std::string, int> uses;
    for (const std::string& name : names) ++uses[name];
    for (size_t i = 0; i < names.size(); ++i) {
      if (!names[i].empty() && uses[names[i]] == 1) continue;
      const std::string own = "light" + std::to_string(i);
      changed = changed || names[i] != own;
      names[i] = own;
    }
  }
  return names;
}

std::vector<std::string> light_names(const std::vector<std::string>& names) {
  SmallGltf g;
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  for (const std::string& name : names) {
    json node = {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}};
    if (!name.empty()) node["name"] = name;
    g.json["scenes"][0]["nodes"].push_back(g.json["nodes"].size());
    g.json["nodes"].push_back(node);
  }
  std::vector<std::string> read;
  for (const Light& light : g.load().lights) read.push_back(light.name);
  return read;
}

TEST(LightNames, AreMadeUniqueAsTheRuleSays) {
  std::mt19937 random(3);
  for (int run = 0; run < 40; ++run) {
    std::vector<std::string> names(2 + random() % 8);
    for (std::string& name : names) name = random() % 6 == 0 ? "" : "light" + std::to_string(random() % 9);
    EXPECT_EQ(light_names(names), unique_names(names)) << json(names);
  }
}

// Each light has the name that the next one would get, so that the clash of the last two passes through all of them.
// That once took a pass over all lights for each.
TEST(LightNames, OfAChainOfClashes) {
  std::vector<std::string> names;
  for (int i = 0; i < 1500; ++i) names.push_back("light" + std::to_string(i + 1));
  names.back() = names[names.size() - 2];
  const std::vector<std::string> read = light_names(names);
  EXPECT_THAT(std::set<std::string>(read.begin(), read.end()), SizeIs(read.size()));
}

TEST(Hierarchies, DeeperThanTheLimitAreRefusedAsSuch) {
  SmallGltf g;
  for (size_t i = 1; i <= 1001; ++i) {
    g.json["nodes"][i - 1]["children"] = {i};
    g.json["nodes"].push_back({{"name", "n" + std::to_string(i)}});
  }
  EXPECT_THAT(g.load_error(), HasSubstr("node n1001 lies deeper than 1000 nodes; "));
}

TEST(Warnings, BehindTheThousandthAreNotKept) {
  SmallGltf g;
  for (size_t i = 1; i < 1500; ++i) {
    g.json["nodes"].push_back({{"rotation", {0, 0, 0, 0}}});
    g.json["scenes"][0]["nodes"].push_back(i);
  }
  const Content content = g.load();
  ASSERT_THAT(content.warnings, SizeIs(1001));
  EXPECT_THAT(content.warnings.back(), HasSubstr("there are more"));
}

}  // namespace
}  // namespace sideray::scenes::bombs_test
