#include "scenes/images/images.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

constexpr float infinity = std::numeric_limits<float>::infinity();

Plane floats(const char* name, Plane::Type type, std::vector<float> values) {
  return {name, type, std::move(values), {}};
}

Image gradient(uint32_t width, uint32_t height) {
  Image image{width, height, {}, true};
  Plane r = floats("R", Plane::Type::half, {}), z = floats("Z", Plane::Type::single, {});
  Plane id{"id.surface", Plane::Type::uint, {}, {}};
  for (uint32_t i = 0; i < width * height; ++i) {
    r.values.push_back(static_cast<float>(i % 1024) / 16.0f);  // exact in half
    z.values.push_back(std::sqrt(static_cast<float>(i)));
    id.uint_values.push_back(0xffffffffu - i);
  }
  z.values[1] = infinity;
  image.planes = {r, z, id};
  return image;
}

TEST(Exr, RoundTripKeepsEveryTypeAndOrder) {
  const ScratchFolder folder;
  const Image image = gradient(37, 21);
  write_exr(folder / "a.exr", image);
  const Image read = read_image(folder / "a.exr");
  EXPECT_EQ(read.width, 37u);
  EXPECT_EQ(read.height, 21u);
  EXPECT_TRUE(read.linear);
  ASSERT_EQ(read.planes.size(), 3u);
  EXPECT_EQ(read.find("R")->values, image.planes[0].values);
  EXPECT_EQ(read.find("R")->type, Plane::Type::half);
  EXPECT_EQ(read.find("Z")->values, image.planes[1].values);
  EXPECT_EQ(read.find("Z")->type, Plane::Type::single);
  EXPECT_EQ(read.find("id.surface")->uint_values, image.planes[2].uint_values);
  EXPECT_EQ(read.find("absent"), nullptr);
  EXPECT_EQ(folder.entries(), 1u);
}

// A block that ZIP cannot shrink is stored as it is, so the file's last bytes are its rows in file order.
TEST(Exr, TopRowComesFirstInTheFile) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", {1, 2, {floats("Z", Plane::Type::single, {1.5f, 7.25f})}, true});
  const Bytes bytes = bytes_of(folder / "a.exr");
  float rows[2];
  std::memcpy(rows, bytes.data() + bytes.size() - sizeof(rows), sizeof(rows));
  EXPECT_EQ(rows[0], 1.5f);
  EXPECT_EQ(rows[1], 7.25f);
}

TEST(Exr, HalfOverflowEndsAtTheLargestHalf) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", {5, 1, {floats("R", Plane::Type::half, {1e9f, infinity, -1e9f, 65519.0f, NAN})}, true});
  const std::vector<float> values = read_image(folder / "a.exr").planes[0].values;
  EXPECT_THAT(std::vector<float>(values.begin(), values.begin() + 4), ElementsAre(65504, 65504, -65504, 65504));
  EXPECT_TRUE(std::isnan(values[4]));
}

// Moves the display window of a written file: the header's "displayWindow" box2i is four int32 after its size.
void patch_display_window(const std::string& path, std::vector<int32_t> box) {
  Bytes bytes = bytes_of(path);
  const std::string name("displayWindow\0box2i\0", 20);
  const auto at = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
  ASSERT_NE(at, bytes.end());
  std::memcpy(&*at + name.size() + 4, box.data(), 16);
  put_bytes(path, bytes);
}

TEST(Exr, DataWindowInsideALargerDisplayWindow) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", {2, 1, {floats("R", Plane::Type::half, {3, 4})}, true});
  patch_display_window(folder / "a.exr", {-1, -1, 2, 1});
  const Image read = read_image(folder / "a.exr");
  EXPECT_EQ(read.width, 4u);
  EXPECT_EQ(read.height, 3u);
  EXPECT_THAT(read.planes[0].values, ElementsAre(0, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 0));
}

TEST(Exr, DataWindowCroppedByADisplayWindow) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", {3, 2, {floats("R", Plane::Type::half, {1, 2, 3, 4, 5, 6})}, true});
  patch_display_window(folder / "a.exr", {1, 1, 4, 1});
  EXPECT_THAT(read_image(folder / "a.exr").planes[0].values, ElementsAre(5, 6, 0, 0));
}

TEST(Exr, TruncationIsAnErrorAtEveryLength) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", gradient(16, 40));
  const Bytes bytes = bytes_of(folder / "a.exr");
  for (size_t length = 0; length < bytes.size(); length += 7) {
    put_bytes(folder / "b.exr", std::span(bytes).first(length));
    EXPECT_THAT(message_of([&] { read_image(folder / "b.exr"); }), HasSubstr("b.exr")) << length << " bytes";
  }
}

TEST(Exr, AbsurdSizesAreRefused) {
  const ScratchFolder folder;
  write_exr(folder / "a.exr", {2, 1, {floats("R", Plane::Type::half, {3, 4})}, true});
  patch_display_window(folder / "a.exr", {0, 0, 20000, 20000});
  EXPECT_THAT(message_of([&] { read_image(folder / "a.exr"); }), HasSubstr("use a smaller picture"));
  patch_display_window(folder / "a.exr", {5, 5, -5, -5});
  EXPECT_NE(message_of([&] { read_image(folder / "a.exr"); }), "");
}

TEST(Exr, PlanesThatDoNotFitAreRefused) {
  const ScratchFolder folder;
  EXPECT_THROW(write_exr(folder / "a.exr", {2, 2, {floats("R", Plane::Type::half, {1})}, true}), Error);
  EXPECT_THROW(write_exr(folder / "a.exr", {1, 1, {}, true}), Error);
  const Plane r = floats("R", Plane::Type::half, {1});
  EXPECT_THROW(write_exr(folder / "a.exr", {1, 1, {r, r}, true}), Error);
  EXPECT_EQ(folder.entries(), 0u);
}

// Made by another program (zlib and struct): 1 x 2 RGB 16 bit, 2 x 1 palette with alpha, 2 x 2 grey 8 bit.
const Bytes png_rgb16 = {137, 80,  78,  71,  13,  10,  26,  10,  0,   0,   0,   13,  73,  72,  68,  82,
                         0,   0,   0,   1,   0,   0,   0,   2,   16,  2,   0,   0,   0,   70,  115, 253,
                         51,  0,   0,   0,   22,  73,  68,  65,  84,  120, 218, 99,  248, 255, 159, 129,
                         161, 129, 129, 129, 145, 145, 137, 145, 129, 1,   0,   29,  139, 2,   132, 205,
                         181, 64,  2,   0,   0,   0,   0,   73,  69,  78,  68,  174, 66,  96,  130};
const Bytes png_palette = {137, 80, 78,  71, 13,  10,  26,  10, 0,   0,   0,   13,  73,  72,  68,  82,  0,
                           0,   0,  2,   0,  0,   0,   1,   8,  3,   0,   0,   0,   195, 252, 143, 184, 0,
                           0,   0,  6,   80, 76,  84,  69,  10, 20,  30,  200, 100, 50,  119, 160, 179, 156,
                           0,   0,  0,   2,  116, 82,  78,  83, 255, 128, 8,   15,  179, 106, 0,   0,   0,
                           11,  73, 68,  65, 84,  120, 218, 99, 96,  100, 0,   0,   0,   5,   0,   2,   66,
                           194, 68, 159, 0,  0,   0,   0,   73, 69,  78,  68,  174, 66,  96,  130};
const Bytes png_grey = {137, 80, 78, 71,  13,  10,  26,  10, 0,  0,   0,   13, 73,  72,  68,  82, 0,   0,
                        0,   2,  0,  0,   0,   2,   8,   0,  0,  0,   0,   87, 221, 82,  248, 0,  0,   0,
                        14,  73, 68, 65,  84,  120, 218, 99, 96, 248, 207, 96, 156, 6,   0,   4,  206, 1,
                        153, 4,  29, 155, 148, 0,   0,   0,  0,  73,  69,  78, 68,  174, 66,  96, 130};

TEST(Png, SixteenBitsAreRead) {
  const ScratchFolder folder;
  put_bytes(folder / "a.png", png_rgb16);
  const Image image = read_image(folder / "a.png");
  EXPECT_FALSE(image.linear);
  EXPECT_EQ(image.width, 1u);
  EXPECT_THAT(image.find("R")->values, ElementsAre(1.0f, 257.0f / 65535.0f));
  EXPECT_THAT(image.find("G")->values, ElementsAre(0.0f, 513.0f / 65535.0f));
  EXPECT_THAT(image.find("B")->values, ElementsAre(32768.0f / 65535.0f, 0.0f));
  EXPECT_EQ(image.find("A"), nullptr);
}

TEST(Png, PaletteAndGreyAreExpanded) {
  const Decoded palette = decode_image(png_palette, "palette");
  EXPECT_THAT(palette.rgba, ElementsAre(200, 100, 50, 128, 10, 20, 30, 255));
  const Decoded grey = decode_image(png_grey, "grey");
  EXPECT_THAT(grey.rgba, ElementsAre(0, 0, 0, 255, 255, 255, 255, 255, 51, 51, 51, 255, 102, 102, 102, 255));
  const Decoded sixteen = decode_image(png_rgb16, "sixteen");
  EXPECT_THAT(sixteen.rgba, ElementsAre(255, 0, 128, 255, 1, 2, 0, 255));
}

TEST(Png, RoundTrip) {
  const ScratchFolder folder;
  Bytes rgb(3 * 5 * 4);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(7 * i);
  write_png(folder / "a.png", 5, 4, rgb);
  const Image image = read_image(folder / "a.png");
  for (size_t i = 0; i < 20; ++i) EXPECT_EQ(image.planes[1].values[i], static_cast<float>(rgb[3 * i + 1]) / 255.0f);
  EXPECT_EQ(quantize(display_values(image, 3.0f, Tonemap::aces)), rgb) << "display pictures come back as they are";
  EXPECT_THROW(write_png(folder / "b.png", 5, 5, rgb), Error);
}

TEST(Png, TruncationIsAnErrorAtEveryLength) {
  for (const Bytes& png : {png_rgb16, png_palette, png_grey}) {
    // The 12 bytes of the end chunk carry no pixels, but a file without them was cut.
    for (size_t length = 0; length < png.size(); ++length) {
      EXPECT_THROW(decode_image(std::span(png).first(length), "cut"), Error) << length << " bytes";
    }
  }
}

TEST(Png, AbsurdSizeIsRefusedBeforeAllocating) {
  const ScratchFolder folder;
  Bytes png = png_grey;
  png[18] = 1;  // width 65538, with the header's checksum now wrong: either way one clear line
  EXPECT_NE(message_of([&] { decode_image(png, "wide.png"); }), "");
}

TEST(Hdr, FlatPixelsTopRowFirst) {
  const ScratchFolder folder;
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n";
  Bytes bytes(text.begin(), text.end());
  bytes.insert(bytes.end(), {128, 64, 32, 129, 128, 128, 128, 140});
  put_bytes(folder / "a.hdr", bytes);
  const Image image = read_image(folder / "a.hdr");
  EXPECT_TRUE(image.linear);
  // Radiance: value = mantissa * 2^(exponent - 136).
  EXPECT_THAT(image.find("R")->values, ElementsAre(1.0f, 2048.0f));
  EXPECT_THAT(image.find("B")->values, ElementsAre(0.25f, 2048.0f));
  bytes.resize(bytes.size() - 5);
  put_bytes(folder / "b.hdr", bytes);
  EXPECT_THAT(message_of([&] { read_image(folder / "b.hdr"); }), HasSubstr("ends too early"));
}

TEST(Files, ProblemsAreOneClearLine) {
  const ScratchFolder folder;
  const Image image{1, 1, {floats("R", Plane::Type::half, {1})}, true};
  EXPECT_THAT(message_of([&] { write_exr(folder / "no/such/a.exr", image); }), HasSubstr("create the folder first"));
  std::filesystem::create_directory(folder / "dir.exr");
  EXPECT_THAT(message_of([&] { write_exr(folder / "dir.exr", image); }), HasSubstr("not a regular file"));
  EXPECT_THAT(message_of([&] { write_exr("/dev/null", image); }), HasSubstr("not a regular file"));
  EXPECT_THAT(message_of([&] { read_image(folder / "none.exr"); }), HasSubstr("check the path"));
  EXPECT_THAT(message_of([&] { read_image(folder / "dir.exr"); }), HasSubstr("not a regular file"));
  EXPECT_THAT(message_of([&] { read_image(folder / "a.tiff"); }), HasSubstr("use .png, .exr or .hdr"));
  put_bytes(folder / "text.exr", Bytes{'h', 'i'});
  EXPECT_THAT(message_of([&] { read_image(folder / "text.exr"); }), HasSubstr("not an OpenEXR file"));
}

TEST(Files, ALinkStaysAndItsTargetIsWritten) {
  const ScratchFolder folder;
  const Image image{1, 1, {floats("R", Plane::Type::half, {1})}, true};
  std::filesystem::create_directory(folder / "real");
  std::filesystem::create_symlink("real/a.exr", folder / "second.exr");
  std::filesystem::create_symlink(folder / "second.exr", folder / "first.exr");
  for (const char* state : {"no target yet", "target exists"}) {
    write_exr(folder / "first.exr", image);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "first.exr")) << state;
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "second.exr")) << state;
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "real/a.exr")) << state;
  }
  std::filesystem::create_symlink("loop.exr", folder / "loop.exr");
  EXPECT_THAT(message_of([&] { write_exr(folder / "loop.exr", image); }), HasSubstr("loop.exr: "));
  std::filesystem::create_symlink("gone/a.exr", folder / "lost.exr");
  EXPECT_THAT(message_of([&] { write_exr(folder / "lost.exr", image); }), HasSubstr("create the folder first"));
}

TEST(Files, FullDiskLeavesTheOldFile) {
  const ScratchFolder folder;
  put_bytes(folder / "a.exr", Bytes{'o', 'l', 'd'});
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = message_of([&] { write_exr(folder / "a.exr", gradient(64, 64)); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal_before);
  EXPECT_THAT(message, HasSubstr("free some space"));
  EXPECT_THAT(bytes_of(folder / "a.exr"), ElementsAre('o', 'l', 'd'));
  EXPECT_EQ(folder.entries(), 1u) << "the temporary file is gone";
}

double oetf(double x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

std::vector<float> displayed(std::vector<float> rgb, float ev, Tonemap tonemap) {
  Image image{static_cast<uint32_t>(rgb.size() / 3), 1, {}, true};
  for (size_t c = 0; c < 3; ++c) {
    Plane plane = floats(std::array{"R", "G", "B"}[c], Plane::Type::single, {});
    for (size_t i = c; i < rgb.size(); i += 3) plane.values.push_back(rgb[i]);
    image.planes.push_back(plane);
  }
  return display_values(image, ev, tonemap);
}

TEST(Tonemap, NoneClampsAndEncodes) {
  const auto values = displayed({0.18f, 0.002f, 1.0f, -1.0f, NAN, infinity}, 0, Tonemap::none);
  EXPECT_NEAR(values[0], oetf(0.18), 1e-6);
  EXPECT_NEAR(values[1], 0.02584, 1e-6);
  EXPECT_THAT(std::vector<float>(values.begin() + 2, values.end()), ElementsAre(1, 0, 0, 1));
  EXPECT_NEAR(displayed({0.09f, 0, 0}, 1, Tonemap::none)[0], oetf(0.18), 1e-6);
}

TEST(Tonemap, ReinhardAndAcesFollowTheirFormulas) {
  for (const double x : {0.01, 0.18, 1.0, 4.0, 100.0}) {
    const auto input = static_cast<float>(x);
    EXPECT_NEAR(displayed({input, 0, 0}, 0, Tonemap::reinhard)[0], oetf(x / (1 + x)), 1e-6);
    const double aces = (2.51 * x * x + 0.03 * x) / (2.43 * x * x + 0.59 * x + 0.14);
    EXPECT_NEAR(displayed({input, 0, 0}, 0, Tonemap::aces)[0], oetf(std::min(aces, 1.0)), 1e-6);
  }
  for (const Tonemap t : {Tonemap::none, Tonemap::reinhard, Tonemap::aces, Tonemap::aces_filmic, Tonemap::pbr_neutral}) {
    EXPECT_EQ(displayed({infinity, infinity, infinity}, 0, t)[0], 1.0f);
  }
}

// Grey stays grey, up to the matrices' rounding; the fit is known at both ends; bright colours turn to white.
TEST(Tonemap, AcesFilmicIsHillsFitOfBrighterLight) {
  for (const double x : {0.0, 0.18, 1.0, 4.0, 100.0}) {
    const auto input = static_cast<float>(x);
    const auto values = displayed({input, input, input}, 0, Tonemap::aces_filmic);
    const double v = x / 0.6, fit = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    for (const float c : values) EXPECT_NEAR(c, oetf(std::clamp(fit, 0.0, 1.0)), 1e-4) << x;
  }
  const auto red = displayed({0.5f, 0, 0}, 0, Tonemap::aces_filmic), bright = displayed({100, 1, 1}, 0, Tonemap::aces_filmic);
  EXPECT_GT(red[0], 2 * red[1]);
  EXPECT_GT(bright[1], 0.8f);
}

// Properties the Khronos specification promises: base colours up to 0.8 - 0.04 are only shifted by F90 = 0.04, greys
// stay grey, and the brightest input tends to white.
TEST(Tonemap, PbrNeutralKeepsBaseColors) {
  const auto shifted = displayed({0.5f, 0.3f, 0.1f}, 0, Tonemap::pbr_neutral);
  EXPECT_NEAR(shifted[0], oetf(0.46), 1e-6);
  EXPECT_NEAR(shifted[1], oetf(0.26), 1e-6);
  EXPECT_NEAR(shifted[2], oetf(0.06), 1e-6);
  const auto grey = displayed({3, 3, 3}, 0, Tonemap::pbr_neutral);
  EXPECT_NEAR(grey[0], oetf(1 - 0.24 * 0.24 / (2.96 + 0.24 - 0.76)), 1e-6);
  EXPECT_FLOAT_EQ(grey[0], grey[2]);
  const auto red = displayed({1e6f, 0, 0}, 0, Tonemap::pbr_neutral);
  EXPECT_GT(red[1], 0.99f);
}

TEST(Tonemap, QuantizeRoundsHalfUp) {
  const std::vector<float> values = {0.0f, std::nextafter(0.5f / 255.0f, 1.0f),  0.49f / 255.0f, 1.0f, 2.0f, -1.0f,
                                     NAN,  std::nextafter(254.5f / 255.0f, 1.0f)};
  EXPECT_THAT(quantize(values), ElementsAre(0, 1, 0, 255, 255, 0, 0, 255));
}

}  // namespace
}  // namespace sideray::scenes
