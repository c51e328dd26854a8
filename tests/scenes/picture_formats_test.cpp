#include <gmock/gmock.h>

#include <algorithm>
#include <array>

#include "scenes/images/images.h"
#include "scenes/support.h"

// Texture pictures in the forms that exporters write, made by ImageMagick 6.9 from known colours.
namespace sideray::scenes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

const Bytes webp_lossless = {82, 73,  70,  70,  58,  0,  0,   0,  87,  69,  66,  80,  86,  80,  56,  76,  46,
                             0,  0,   0,   47,  1,   64, 0,   16, 31,  32,  16,  72,  146, 216, 31,  117, 13,
                             33, 1,   65,  245, 255, 47, 129, 0,  193, 136, 255, 75,  2,   18,  194, 115, 89,
                             46, 240, 150, 165, 74,  40, 9,   16, 0,   69,  25,  137, 232, 127, 48};
const Bytes webp_lossy = {82,  73,  70,  70,  62,  0,   0,   0,  87,  69,  66, 80,  86,  80,  56,  32,  50,  0,
                          0,   0,   208, 1,   0,   157, 1,   42, 8,   0,   8,  0,   0,   192, 18,  37,  160, 2,
                          116, 186, 1,   248, 0,   3,   176, 0,  254, 218, 38, 255, 238, 243, 126, 211, 215, 180,
                          245, 253, 76,  255, 248, 202, 159, 32, 63,  227, 42, 127, 197, 204, 0,   0};
const Bytes webp_lossy_alpha = {82,  73,  70,  70,  98,  0,   0,   0,  87,  69,  66,  80,  86,  80,  56,  88,  10,  0,
                                0,   0,   16,  0,   0,   0,   7,   0,  0,   7,   0,   0,   65,  76,  80,  72,  10,  0,
                                0,   0,   1,   7,   80,  192, 136, 8,  68,  68,  255, 3,   86,  80,  56,  32,  50,  0,
                                0,   0,   208, 1,   0,   157, 1,   42, 8,   0,   8,   0,   0,   192, 18,  37,  160, 2,
                                116, 186, 1,   248, 0,   3,   176, 0,  254, 218, 38,  255, 238, 243, 126, 211, 215, 180,
                                245, 253, 76,  255, 248, 202, 159, 32, 63,  227, 42,  127, 197, 204, 0,   0};
const Bytes png_interlaced = {137, 80,  78,  71,  13,  10, 26,  10, 0,   0,  0,   13, 73,  72,  68,  82,  0,
                              0,   0,   3,   0,   0,   0,  3,   8,  2,   0,  0,   1,  174, 77,  18,  126, 0,
                              0,   0,   28,  73,  68,  65, 84,  8,  215, 5,  193, 1,  1,   0,   0,   8,   2,
                              32,  234, 120, 62,  55,  0,  101, 84, 17,  86, 141, 8,  199, 3,   101, 9,   6,
                              0,   72,  211, 221, 222, 0,  0,   0,  0,   73, 69,  78, 68,  174, 66,  96,  130};
const Bytes png_grey_alpha16 = {
    137, 80,  78,  71, 13, 10,  26,  10,  0,   0,   0,   13,  73, 72, 68, 82, 0,  0,   0,  2,   0,   0,   0,   1,   16,
    4,   0,   0,   0,  14, 187, 107, 66,  0,   0,   0,   17,  73, 68, 65, 84, 8,  215, 99, 248, 255, 255, 255, 127, 6,
    134, 255, 255, 1,  28, 236, 5,   251, 161, 130, 178, 118, 0,  0,  0,  0,  73, 69,  78, 68,  174, 66,  96,  130};
const Bytes jpeg_grey = {
    255, 216, 255, 224, 0, 16, 74, 70, 73,  70,  0, 1,   1,   0, 0, 1, 0,   1,   0, 0,  255, 219, 0,   67,  0,  2, 1,
    1,   1,   1,   1,   2, 1,  1,  1,  2,   2,   2, 2,   2,   4, 3, 2, 2,   2,   2, 5,  4,   4,   3,   4,   6,  5, 6,
    6,   6,   5,   6,   6, 6,  7,  9,  8,   6,   7, 9,   7,   6, 6, 8, 11,  8,   9, 10, 10,  10,  10,  10,  6,  8, 11,
    12,  11,  10,  12,  9, 10, 10, 10, 255, 192, 0, 11,  8,   0, 8, 0, 8,   1,   1, 17, 0,   255, 196, 0,   20, 0, 1,
    0,   0,   0,   0,   0, 0,  0,  0,  0,   0,   0, 0,   0,   0, 0, 8, 255, 196, 0, 20, 16,  1,   0,   0,   0,  0, 0,
    0,   0,   0,   0,   0, 0,  0,  0,  0,   0,   0, 255, 218, 0, 8, 1, 1,   0,   0, 63, 0,   25,  191, 255, 217};
const Bytes jpeg_cmyk = {
    255, 216, 255, 238, 0,  14, 65, 100, 111, 98, 101, 0,   100, 0,  0,   0,   0,   2,   255, 219, 0,  67, 0,
    2,   1,   1,   1,   1,  1,  2,  1,   1,   1,  2,   2,   2,   2,  2,   4,   3,   2,   2,   2,   2,  5,  4,
    4,   3,   4,   6,   5,  6,  6,  6,   5,   6,  6,   6,   7,   9,  8,   6,   7,   9,   7,   6,   6,  8,  11,
    8,   9,   10,  10,  10, 10, 10, 6,   8,   11, 12,  11,  10,  12, 9,   10,  10,  10,  255, 219, 0,  67, 1,
    2,   2,   2,   2,   2,  2,  5,  3,   3,   5,  10,  7,   6,   7,  10,  10,  10,  10,  10,  10,  10, 10, 10,
    10,  10,  10,  10,  10, 10, 10, 10,  10,  10, 10,  10,  10,  10, 10,  10,  10,  10,  10,  10,  10, 10, 10,
    10,  10,  10,  10,  10, 10, 10, 10,  10,  10, 10,  10,  10,  10, 10,  10,  10,  10,  255, 192, 0,  20, 8,
    0,   8,   0,   8,   4,  1,  17, 0,   2,   17, 1,   3,   17,  1,  4,   17,  0,   255, 196, 0,   21, 0,  1,
    1,   0,   0,   0,   0,  0,  0,  0,   0,   0,  0,   0,   0,   0,  0,   7,   9,   255, 196, 0,   20, 16, 1,
    0,   0,   0,   0,   0,  0,  0,  0,   0,   0,  0,   0,   0,   0,  0,   0,   255, 196, 0,   21,  1,  1,  1,
    0,   0,   0,   0,   0,  0,  0,  0,   0,   0,  0,   0,   0,   0,  8,   9,   255, 196, 0,   20,  17, 1,  0,
    0,   0,   0,   0,   0,  0,  0,  0,   0,   0,  0,   0,   0,   0,  0,   255, 218, 0,   14,  4,   1,  0,  2,
    17,  3,   17,  4,   0,  0,  63, 0,   3,   53, 19,  173, 72,  31, 255, 217};
const Bytes jpeg_progressive = {
    255, 216, 255, 224, 0,   16,  74,  70,  73,  70,  0,   1,   1,   0,   0,   1,   0,   1,   0,   0,   255, 219, 0,
    67,  0,   3,   2,   2,   3,   2,   2,   3,   3,   3,   3,   4,   3,   3,   4,   5,   8,   5,   5,   4,   4,   5,
    10,  7,   7,   6,   8,   12,  10,  12,  12,  11,  10,  11,  11,  13,  14,  18,  16,  13,  14,  17,  14,  11,  11,
    16,  22,  16,  17,  19,  20,  21,  21,  21,  12,  15,  23,  24,  22,  20,  24,  18,  20,  21,  20,  255, 219, 0,
    67,  1,   3,   4,   4,   5,   4,   5,   9,   5,   5,   9,   20,  13,  11,  13,  20,  20,  20,  20,  20,  20,  20,
    20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,
    20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  255, 194, 0,
    17,  8,   0,   8,   0,   8,   3,   1,   17,  0,   2,   17,  1,   3,   17,  1,   255, 196, 0,   20,  0,   1,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   3,   255, 196, 0,   21,  1,   1,   1,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   6,   7,   255, 218, 0,   12,  3,   1,   0,   2,
    16,  3,   16,  0,   0,   1,   16,  244, 143, 255, 196, 0,   20,  16,  1,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   1,   0,   1,   5,   2,   127, 255, 196, 0,   20,
    17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,
    3,   1,   1,   63,  1,   127, 255, 196, 0,   20,  17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   2,   1,   1,   63,  1,   127, 255, 196, 0,   20,  16,  1,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   1,   0,   6,
    63,  2,   127, 255, 196, 0,   20,  16,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   255, 218, 0,   8,   1,   1,   0,   1,   63,  33,  127, 255, 218, 0,   12,  3,   1,   0,   2,   0,   3,
    0,   0,   0,   16,  159, 255, 196, 0,   20,  17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   255, 218, 0,   8,   1,   3,   1,   1,   63,  16,  127, 255, 196, 0,   20,  17,  1,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   2,   1,   1,   63,
    16,  127, 255, 196, 0,   20,  16,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   255, 218, 0,   8,   1,   1,   0,   1,   63,  16,  127, 255, 217};

// Every texel of `decoded` within `tolerance` of one colour.
void expect_flat(const Decoded& decoded, std::array<int, 4> color, int tolerance) {
  ASSERT_EQ(decoded.rgba.size(), size_t{8} * 8 * 4);
  for (size_t i = 0; i < decoded.rgba.size(); ++i) EXPECT_NEAR(decoded.rgba[i], color[i % 4], tolerance) << i;
}

TEST(Webp, LosslessKeepsEveryTexelAndAlpha) {
  const Decoded decoded = decode_image(webp_lossless, "q");
  EXPECT_EQ(decoded.width, 2u);
  EXPECT_EQ(decoded.height, 2u);
  EXPECT_THAT(decoded.rgba, ElementsAre(255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 255, 10, 20, 30, 255));
}

// One colour has no frequencies to lose: what is left is the rounding to 8-bit YUV and back.
TEST(Webp, LossyWithAndWithoutAlpha) {
  expect_flat(decode_image(webp_lossy, "flat"), {200, 100, 50, 255}, 2);
  expect_flat(decode_image(webp_lossy_alpha, "flat"), {200, 100, 50, 128}, 2);
}

TEST(Webp, TruncationIsAnErrorAtEveryLength) {
  for (const Bytes& webp : {webp_lossless, webp_lossy, webp_lossy_alpha}) {
    for (size_t length = 0; length < webp.size(); ++length) {
      EXPECT_THAT(message_of([&] { decode_image(std::span(webp).first(length), "cut.webp"); }), HasSubstr("cut.webp: "))
          << length << " bytes";
    }
  }
}

TEST(Webp, AnimationsAreRefusedByName) {
  // An extended header whose animation bit is set.
  const Bytes header = {'R', 'I', 'F', 'F', 22, 0, 0, 0, 'W', 'E', 'B', 'P', 'V', 'P', '8',
                        'X', 10,  0,   0,   0,  2, 0, 0, 0,   1,   0,   0,   1,   0,   0};
  EXPECT_THAT(message_of([&] { decode_image(header, "film.webp"); }), HasSubstr("film.webp: it is an animation"));
}

TEST(Jpeg, ProgressiveGreyAndCmyk) {
  expect_flat(decode_image(jpeg_progressive, "p"), {200, 100, 50, 255}, 2);
  expect_flat(decode_image(jpeg_grey, "g"), {77, 77, 77, 255}, 1);
  expect_flat(decode_image(jpeg_cmyk, "c"), {200, 100, 50, 255}, 2);
}

TEST(Png, InterlacedAndSixteenBitGreyWithAlpha) {
  EXPECT_THAT(decode_image(png_interlaced, "i").rgba,
              ElementsAre(0, 0, 0, 255, 128, 0, 0, 255, 255, 0, 0, 255, 0, 128, 0, 255, 128, 128, 0, 255, 255, 128, 0,
                          255, 0, 255, 0, 255, 128, 255, 0, 255, 255, 255, 0, 255));
  EXPECT_THAT(decode_image(png_grey_alpha16, "ga").rgba, ElementsAre(255, 255, 255, 255, 0, 0, 0, 255));
}

TEST(Pictures, WhatIsNoneOfThemIsNamed) {
  EXPECT_THAT(message_of([] { decode_image({}, "image 0 of a.glb"); }), HasSubstr("image 0 of a.glb: it has no bytes"));
  const Bytes gif = {'G', 'I', 'F', '8', '9', 'a', 1, 0, 1, 0};
  EXPECT_THAT(message_of([&] { decode_image(gif, "a.gif"); }), HasSubstr("a.gif: it is neither PNG, JPEG nor WebP"));
}

// A header of a size above the limit, without data: it is refused before memory is allocated for pixels.
TEST(Pictures, BombsAreRefusedByTheirHeader) {
  Bytes wide = webp_lossless;
  // VP8L: 14 bits of width - 1, then 14 bits of height - 1, from bit 8 of the chunk's data on.
  const size_t bits = 20 + 1;
  wide[bits] = 0xff, wide[bits + 1] = 0xff, wide[bits + 2] = 0xff, wide[bits + 3] = 0x0f;
  EXPECT_NE(message_of([&] { decode_image(wide, "wide.webp"); }), "");
  Bytes jpeg = jpeg_grey;
  const uint8_t start_of_frame[] = {0xff, 0xc0};
  const auto frame = std::search(jpeg.begin(), jpeg.end(), start_of_frame, start_of_frame + 2);
  ASSERT_NE(frame, jpeg.end());
  frame[5] = frame[6] = frame[7] = frame[8] = 0xff;
  EXPECT_THAT(message_of([&] { decode_image(jpeg, "wide.jpg"); }), HasSubstr("wide.jpg: "));
}

}  // namespace
}  // namespace sideray::scenes
