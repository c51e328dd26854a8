#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <random>

#include "scenes/support.h"

// Tests that output of the two libraries' encoders is read back, or refused if damaged.
namespace sideray::scenes::gltf_compression_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AnyOf;
using testing::ElementsAreArray;
using testing::HasSubstr;

// A wavy sheet of n x n quads: positions, unit normals, uvs, shared vertices.
struct Sheet {
  std::vector<float> positions, normals, uvs;
  std::vector<uint16_t> indices;

  explicit Sheet(uint16_t n) {
    for (uint16_t y = 0; y <= n; ++y) {
      for (uint16_t x = 0; x <= n; ++x) {
        const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n, tilt = 0.3f * std::cos(6 * u);
        const float length = std::hypot(tilt, 1.0f);
        positions.insert(positions.end(), {u, v, 0.05f * std::sin(6 * u)});
        normals.insert(normals.end(), {-tilt / length, 0, 1 / length});
        uvs.insert(uvs.end(), {u, 1 - v});
      }
    }
    const auto at = [&](int x, int y) { return static_cast<uint16_t>(y * (n + 1) + x); };
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        for (const uint16_t i : {at(x, y), at(x + 1, y), at(x + 1, y + 1)}) indices.push_back(i);
        for (const uint16_t i : {at(x, y), at(x + 1, y + 1), at(x, y + 1)}) indices.push_back(i);
      }
    }
  }
  size_t vertices() const { return positions.size() / 3; }
};

using Corner = std::array<float, 8>;  // position, normal, uv

// Returns the triangles in an order that does not depend on encoders: each begins with its smallest corner, and they
// are sorted by centre.
std::vector<std::array<Corner, 3>> triangles_of(const Mesh& mesh) {
  std::vector<std::array<Corner, 3>> triangles;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::array<Corner, 3> t{};
    for (size_t k = 0; k < 3; ++k) {
      const size_t v = mesh.indices[i + k];
      std::copy_n(&mesh.positions[3 * v], 3, t[k].begin());
      if (!mesh.normals.empty()) std::copy_n(&mesh.normals[3 * v], 3, t[k].begin() + 3);
      if (!mesh.uv0.empty()) std::copy_n(&mesh.uv0[2 * v], 2, t[k].begin() + 6);
    }
    triangles.push_back(t);
  }
  return triangles;
}

float corner_distance(const Corner& a, const Corner& b, size_t first, size_t last) {
  float largest = 0;
  for (size_t i = first; i < last; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

// Largest differences over all triangles of `a`, each to the nearest of `b` in the turn that fits best.
struct Difference {
  float position = 0, normal = 0, uv = 0;
};

Difference compare(const Mesh& a, const Mesh& b) {
  const auto left = triangles_of(a), right = triangles_of(b);
  Difference worst;
  for (const auto& t : left) {
    Difference best{.position = INFINITY};
    for (const auto& other : right) {
      for (size_t turn = 0; turn < 3; ++turn) {
        Difference d;
        for (size_t k = 0; k < 3; ++k) {
          const Corner& o = other[(k + turn) % 3];
          d.position = std::max(d.position, corner_distance(t[k], o, 0, 3));
          d.normal = std::max(d.normal, corner_distance(t[k], o, 3, 6));
          d.uv = std::max(d.uv, corner_distance(t[k], o, 6, 8));
        }
        // Ties in position (coincident triangles) go to the best of the rest.
        if (d.position + d.normal + d.uv < best.position + best.normal + best.uv) best = d;
      }
    }
    worst.position = std::max(worst.position, best.position);
    worst.normal = std::max(worst.normal, best.normal);
    worst.uv = std::max(worst.uv, best.uv);
  }
  return worst;
}

// ---- Draco ----

constexpr int position_bits = 14, normal_bits = 10, uv_bits = 12;

std::vector<uint8_t> draco_encode(const Sheet& sheet, int method) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(sheet.indices.size() / 3));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  for (size_t i = 0; i < sheet.indices.size(); i += 3) {
    const draco::FaceIndex face(static_cast<uint32_t>(i / 3));
    const auto set = [&](int attribute, const std::vector<float>& values, size_t n) {
      builder.SetAttributeValuesForFace(attribute, face, &values[n * sheet.indices[i]],
                                        &values[n * sheet.indices[i + 1]], &values[n * sheet.indices[i + 2]]);
    };
    set(position, sheet.positions, 3);
    set(normal, sheet.normals, 3);
    set(uv, sheet.uvs, 2);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, normal_bits);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, uv_bits);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

SmallGltf draco_file(const Sheet& sheet, std::vector<uint8_t> stream) {
  SmallGltf g;
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const size_t view = g.add_view(stream);
  g.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", sheet.vertices()}},
                         {{"componentType", 5126}, {"type", "VEC3"}, {"count", sheet.vertices()}},
                         {{"componentType", 5126}, {"type", "VEC2"}, {"count", sheet.vertices()}},
                         {{"componentType", 5123}, {"type", "SCALAR"}, {"count", sheet.indices.size()}}};
  g.primitive() = {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}, {"indices", 3}};
  g.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}};
  return g;
}

Mesh plain(const Sheet& sheet) {
  Mesh mesh;
  mesh.positions = sheet.positions, mesh.normals = sheet.normals, mesh.uv0 = sheet.uvs;
  mesh.indices.assign(sheet.indices.begin(), sheet.indices.end());
  return mesh;
}

class Draco : public testing::TestWithParam<int> {};

TEST_P(Draco, DecodesToTheMeshWithinItsQuantization) {
  const Sheet sheet(9);
  const Content content = draco_file(sheet, draco_encode(sheet, GetParam())).load();
  ASSERT_EQ(content.meshes.size(), 1u);
  EXPECT_EQ(content.meshes[0].indices.size(), sheet.indices.size());
  EXPECT_EQ(content.meshes[0].positions.size(), sheet.positions.size());
  const Difference d = compare(content.meshes[0], plain(sheet));
  // Draco rounds to a grid over the largest side (1 here) and to an octahedron unfolded over a square.
  EXPECT_LT(d.position, 1.0f / (1 << position_bits));
  EXPECT_LT(d.uv, 1.0f / (1 << uv_bits));
  EXPECT_LT(d.normal, 4.0f / (1 << normal_bits));
  EXPECT_GT(d.position, 0.0f) << "the data went through the encoder";
  EXPECT_TRUE(content.warnings.empty());
}

TEST_P(Draco, DamagedStreamsNeverDoMoreThanThrow) {
  const Sheet sheet(6);
  const std::vector<uint8_t> stream = draco_encode(sheet, GetParam());
  std::mt19937 random(1);
  size_t refused = 0;
  for (int round = 0; round < 400; ++round) {
    std::vector<uint8_t> damaged = stream;
    if (round % 2 == 0) damaged.resize(random() % stream.size());
    for (int i = 0; i < round % 4 && !damaged.empty(); ++i)
      damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
    if (damaged.empty()) continue;
    const std::string message = draco_file(sheet, damaged).load_error();
    refused += message.empty() ? 0 : 1;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_GT(refused, 200u) << "what was cut is refused";
}

TEST_P(Draco, CountsOfTheStreamAreHeldAgainstTheAccessors) {
  const Sheet sheet(6);
  SmallGltf g = draco_file(sheet, draco_encode(sheet, GetParam()));
  g.json["accessors"][3]["count"] = 3 * 71;
  EXPECT_THAT(g.load_error(), HasSubstr("holds 72 triangles where the accessor has 71"));
}

INSTANTIATE_TEST_SUITE_P(Methods, Draco,
                         testing::Values(draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING),
                         [](const testing::TestParamInfo<int>& method) {
                           return method.param == draco::MESH_EDGEBREAKER_ENCODING ? "edgebreaker" : "sequential";
                         });

// One triangle and a thousand vertices that it does not use, kept by the sequential method.
std::vector<uint8_t> draco_with_unused_vertices(uint32_t vertices, int speed) {
  draco::Mesh mesh;
  mesh.set_num_points(vertices);
  mesh.AddFace({draco::PointIndex(vertices - 3), draco::PointIndex(vertices - 2), draco::PointIndex(vertices - 1)});
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  draco::PointAttribute* values = mesh.attribute(mesh.AddAttribute(position, true, vertices));
  for (uint32_t i = 0; i < vertices; ++i) {
    const float p[3] = {static_cast<float>(i % 10), static_cast<float>(i / 10), 0};
    values->SetAttributeValue(draco::AttributeValueIndex(i), p);
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

TEST(DracoFile, VerticesThatNoCornerUsesAreAccepted) {
  // Slower speeds compress the triangles' corners, the fastest stores them in 1, 2 or more bytes.
  for (const uint32_t vertices : {100u, 1000u, 70000u}) {
    for (const int speed : {0, 10}) {
      SCOPED_TRACE(testing::Message() << vertices << " vertices, speed " << speed);
      SmallGltf g;
      g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
      const size_t view = g.add_view(draco_with_unused_vertices(vertices, speed));
      g.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", vertices}},
                             {{"componentType", 5123}, {"type", "SCALAR"}, {"count", 3}}};
      g.primitive() = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
      g.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                                   {"attributes", {{"POSITION", 0}}}};
      const Content content = g.load();
      EXPECT_THAT(content.warnings, testing::IsEmpty());
      ASSERT_EQ(content.meshes.at(0).positions.size(), 3 * vertices);
      EXPECT_EQ(content.meshes[0].indices, (std::vector<uint32_t>{vertices - 3, vertices - 2, vertices - 1}));
      const float height = static_cast<float>((vertices - 2) / 10);
      EXPECT_NEAR(content.meshes[0].positions[3 * size_t{vertices} - 5], height, 1e-4f * static_cast<float>(vertices));
      g.json["accessors"][0]["count"] = vertices - 1;
      EXPECT_THAT(g.load_error(),
                  HasSubstr(fmt::format("holds {} vertices where the accessor has {}", vertices, vertices - 1)));
    }
  }
}

TEST(DracoFile, WhatCannotBeReadIsNamed) {
  const Sheet sheet(3);
  const std::vector<uint8_t> stream = draco_encode(sheet, draco::MESH_EDGEBREAKER_ENCODING);
  std::vector<uint8_t> old = stream, points = stream, other = stream;
  old[6] = 1;     // minor version
  points[7] = 0;  // geometry type
  other[0] = 'X';
  EXPECT_THAT(draco_file(sheet, old).load_error(), HasSubstr("version 2.1"));
  EXPECT_THAT(draco_file(sheet, points).load_error(), HasSubstr("points"));
  EXPECT_THAT(draco_file(sheet, other).load_error(), HasSubstr("damaged"));
  SmallGltf g = draco_file(sheet, stream);
  g.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = 9;
  EXPECT_THAT(g.load_error(), HasSubstr("attribute 9"));
  g = draco_file(sheet, stream);
  g.primitive()["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 99;
  EXPECT_THAT(g.load_error(), HasSubstr("bufferView 99"));
  g = draco_file(sheet, stream);
  g.primitive().erase("indices");
  EXPECT_THAT(g.load_error(), HasSubstr("indices"));
}

// ---- meshopt ----

template <typename T>
std::vector<uint8_t> meshopt_vertices(const std::vector<T>& values, size_t count) {
  const size_t stride = values.size() * sizeof(T) / count;
  std::vector<uint8_t> stream(meshopt_encodeVertexBufferBound(count, stride));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), values.data(), count, stride));
  return stream;
}

// The view's decoded place is in the fallback buffer, which has no data.
void add_compressed(SmallGltf& g, const std::vector<uint8_t>& stream, size_t count, size_t stride, const char* mode,
                    const char* filter = nullptr) {
  const size_t view = g.add_view(stream);
  json& v = g.json["bufferViews"][view];
  json e = {{"buffer", 0},
            {"byteOffset", v["byteOffset"]},
            {"byteLength", v["byteLength"]},
            {"byteStride", stride},
            {"mode", mode},
            {"count", count}};
  if (filter != nullptr) e["filter"] = filter;
  v = {{"buffer", 1}, {"byteLength", count * stride}, {"extensions", {{"EXT_meshopt_compression", e}}}};
  if (std::string(mode) == "ATTRIBUTES") v["byteStride"] = stride;
}

SmallGltf meshopt_file(const Sheet& sheet, const std::vector<uint8_t>& positions, const std::vector<uint8_t>& normals,
                       const std::vector<uint8_t>& indices, const char* index_mode) {
  SmallGltf g;
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  g.json["bufferViews"] = json::array();
  add_compressed(g, positions, sheet.vertices(), 12, "ATTRIBUTES");
  add_compressed(g, normals, sheet.vertices(), 8, "ATTRIBUTES", "OCTAHEDRAL");
  add_compressed(g, indices, sheet.indices.size(), 2, index_mode);
  g.json["accessors"] = {
      {{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", sheet.vertices()}},
      {{"bufferView", 1}, {"componentType", 5122}, {"type", "VEC3"}, {"count", sheet.vertices()}, {"normalized", true}},
      {{"bufferView", 2}, {"componentType", 5123}, {"type", "SCALAR"}, {"count", sheet.indices.size()}}};
  g.primitive() = {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}};
  g.json["buffers"] = {{{"byteLength", g.binary.size()}, {"uri", "data.bin"}},
                       {{"byteLength", sheet.vertices() * 20 + sheet.indices.size() * 2},
                        {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  return g;
}

std::vector<uint8_t> octahedral_normals(const Sheet& sheet) {
  std::vector<float> four;
  for (size_t i = 0; i < sheet.vertices(); ++i)
    four.insert(four.end(), {sheet.normals[3 * i], sheet.normals[3 * i + 1], sheet.normals[3 * i + 2], 0});
  std::vector<int16_t> packed(four.size());
  meshopt_encodeFilterOct(packed.data(), sheet.vertices(), 8, 12, four.data());
  return meshopt_vertices(packed, sheet.vertices());
}

std::vector<uint8_t> meshopt_triangles(const Sheet& sheet) {
  const std::vector<uint32_t> wide(sheet.indices.begin(), sheet.indices.end());
  std::vector<uint8_t> stream(meshopt_encodeIndexBufferBound(wide.size(), sheet.vertices()));
  stream.resize(meshopt_encodeIndexBuffer(stream.data(), stream.size(), wide.data(), wide.size()));
  return stream;
}

std::vector<uint8_t> meshopt_sequence(const Sheet& sheet) {
  const std::vector<uint32_t> wide(sheet.indices.begin(), sheet.indices.end());
  std::vector<uint8_t> stream(meshopt_encodeIndexSequenceBound(wide.size(), sheet.vertices()));
  stream.resize(meshopt_encodeIndexSequence(stream.data(), stream.size(), wide.data(), wide.size()));
  return stream;
}

TEST(Meshopt, DecodesVerticesTrianglesAndFilters) {
  const Sheet sheet(9);
  SmallGltf g = meshopt_file(sheet, meshopt_vertices(sheet.positions, sheet.vertices()), octahedral_normals(sheet),
                             meshopt_triangles(sheet), "TRIANGLES");
  const Content content = g.load();
  EXPECT_THAT(content.meshes.at(0).positions, ElementsAreArray(sheet.positions)) << "without loss, in order";
  Mesh expected = plain(sheet);
  expected.uv0.clear();
  EXPECT_LT(compare(content.meshes[0], expected).normal, 2.0f / (1 << 11)) << "12 bits a side";
  EXPECT_EQ(content.meshes[0].indices.size(), sheet.indices.size());
}

TEST(Meshopt, DecodesIndexSequences) {
  const Sheet sheet(4);
  SmallGltf g = meshopt_file(sheet, meshopt_vertices(sheet.positions, sheet.vertices()), octahedral_normals(sheet),
                             meshopt_sequence(sheet), "INDICES");
  EXPECT_THAT(g.load().meshes.at(0).indices, ElementsAreArray(sheet.indices));
}

TEST(Meshopt, ExponentialPositions) {
  const Sheet sheet(4);
  std::vector<uint32_t> packed(sheet.positions.size());
  const int bits = 15;
#if MESHOPTIMIZER_VERSION >= 190  // before, there was no other way to share exponents than this one
  meshopt_encodeFilterExp(packed.data(), sheet.vertices(), 12, bits, sheet.positions.data(),
                          meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(packed.data(), sheet.vertices(), 12, bits, sheet.positions.data());
#endif
  SmallGltf g = meshopt_file(sheet, meshopt_vertices(packed, sheet.vertices()), octahedral_normals(sheet),
                             meshopt_triangles(sheet), "TRIANGLES");
  g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["filter"] = "EXPONENTIAL";
  const Content content = g.load();
  // The components of a vertex share the exponent of the largest, at most 1 here.
  for (size_t i = 0; i < sheet.positions.size(); ++i)
    EXPECT_NEAR(content.meshes.at(0).positions[i], sheet.positions[i], 2.0f / (1 << (bits - 1))) << i;
}

TEST(Meshopt, DamagedStreamsNeverDoMoreThanThrow) {
  const Sheet sheet(6);
  const std::vector<uint8_t> positions = meshopt_vertices(sheet.positions, sheet.vertices());
  const std::vector<uint8_t> normals = octahedral_normals(sheet), indices = meshopt_triangles(sheet);
  std::mt19937 random(1);
  size_t refused = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<uint8_t> streams[] = {positions, normals, indices};
    std::vector<uint8_t>& damaged = streams[round % 3];
    if (round % 2 == 0) damaged.resize(1 + random() % damaged.size());
    for (int i = 0; i < 1 + round % 4; ++i) damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
    const std::string message = meshopt_file(sheet, streams[0], streams[1], streams[2], "TRIANGLES").load_error();
    refused += message.empty() ? 0 : 1;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_GT(refused, 150u) << "what was cut is refused";
}

TEST(Meshopt, WhatTheExtensionLacksIsRefusedBeforeDecoding) {
  const Sheet sheet(3);
  const auto error_with = [&](size_t view, const char* key, const json& value) {
    SmallGltf g = meshopt_file(sheet, meshopt_vertices(sheet.positions, sheet.vertices()), octahedral_normals(sheet),
                               meshopt_triangles(sheet), "TRIANGLES");
    g.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"][key] = value;
    return g.load_error();
  };
  EXPECT_THAT(error_with(0, "byteStride", 13), HasSubstr("13 bytes"));
  EXPECT_THAT(error_with(0, "byteStride", 260), HasSubstr("260 bytes"));
  EXPECT_THAT(error_with(1, "byteStride", 12), HasSubstr("OCTAHEDRAL"));
  EXPECT_THAT(error_with(2, "byteStride", 8), HasSubstr("TRIANGLES"));
  EXPECT_THAT(error_with(2, "count", 52), HasSubstr("52 times"));
  EXPECT_THAT(error_with(0, "mode", "MAGIC"), HasSubstr("MAGIC"));
  EXPECT_THAT(error_with(0, "filter", "COLOR"), HasSubstr("COLOR"));
  EXPECT_THAT(error_with(0, "count", -3), HasSubstr("count"));
  EXPECT_THAT(error_with(0, "count", 2000000000), HasSubstr("damaged")) << "more than these bytes can hold";
  EXPECT_THAT(error_with(0, "buffer", 9), HasSubstr("buffer"));
  EXPECT_THAT(error_with(0, "byteLength", 99999), HasSubstr("outside buffer"));
  EXPECT_THAT(error_with(0, "byteLength", 0), AnyOf(HasSubstr("bufferView"), HasSubstr("damaged")));
}

// ---- The same model from other encoders ----

fs::path assets() {
  return fs::path(SIDERAY_SOURCE_DIR).parent_path() / "shared" / "assets";
}

struct Pair {
  const char *compressed, *plain;
};

class CompressedAsset : public testing::TestWithParam<Pair> {};

TEST_P(CompressedAsset, EqualsItsDecodedCopy) {
  if (!fs::exists(assets())) GTEST_SKIP() << "no test content at " << assets();
  const Content a = load(assets() / GetParam().compressed), b = load(assets() / GetParam().plain);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    const Mesh &left = a.meshes[a.objects[i].mesh], &right = b.meshes[b.objects[i].mesh];
    SCOPED_TRACE(left.name);
    ASSERT_EQ(left.indices.size(), right.indices.size());
    // Both hold what one stream decodes to, in the order of that decoder.
    EXPECT_THAT(left.positions, ElementsAreArray(right.positions));
    EXPECT_THAT(left.normals, ElementsAreArray(right.normals));
    EXPECT_THAT(left.uv0, ElementsAreArray(right.uv0));
    EXPECT_THAT(left.indices, ElementsAreArray(right.indices));
  }
}

const Pair pairs[] = {
    {"KenneyCars_Van/van.gltf", "KenneyCars_Van/van.plain.glb"},
    {"KenneyCars_PoliceCar/police-car.gltf", "KenneyCars_PoliceCar/police-car.plain.glb"},
    {"KenneyWineGlass/glass-wine.gltf", "KenneyWineGlass/glass-wine.plain.glb"},
    {"JapaneseBridgeGarden/JapaneseBridgeGarden.glb", "JapaneseBridgeGarden/JapaneseBridgeGarden.plain.glb"}};

INSTANTIATE_TEST_SUITE_P(Files, CompressedAsset, testing::ValuesIn(pairs),
                         [](const testing::TestParamInfo<Pair>& pair) {
                           std::string name = fs::path(pair.param.compressed).stem().string();
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace sideray::scenes::gltf_compression_test
