// Tests that the hash of a frame's depth sees every texel and every bit that counts, and no other.
#include "rt/history/picture_hash.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace sideray::rt::picture_hash_test {
namespace {

constexpr uint32_t width = 7, height = 5;  // no multiple of the chains of the hash

class HashOfDepth : public testing::TestWithParam<DepthFormat> {
 protected:
  static size_t texel_bytes() {
    return GetParam() == DepthFormat::d16 ? 2 : GetParam() == DepthFormat::d32f_s8 ? 8 : 4;
  }
  // Bytes of a texel with stencil, and with bits that the format leaves undefined.
  static bool has_stencil() { return GetParam() == DepthFormat::d24s8 || GetParam() == DepthFormat::d32f_s8; }
  static size_t stencil_byte() { return GetParam() == DepthFormat::d24s8 ? 0 : 4; }

  PictureHash hash(uint32_t stencil_bits = 0, uint32_t threads = 2) const {
    Executor executor(threads);
    return hash_depth(executor, {texels_.data(), width * texel_bytes(), GetParam()}, width, height, stencil_bits);
  }

  std::vector<std::byte> texels_ = std::vector<std::byte>(width * height * texel_bytes(), std::byte{0x3c});
};

TEST_P(HashOfDepth, differs_with_every_texel) {
  const PictureHash before = hash();
  EXPECT_EQ(hash(0, 1), before);
  for (size_t texel = 0; texel < width * height; ++texel) {
    std::byte& byte = texels_[texel * texel_bytes() + 1];  // of the depth in every format
    byte ^= std::byte{1};
    EXPECT_NE(hash(), before) << texel;
    byte ^= std::byte{1};
  }
  EXPECT_EQ(hash(), before);
}

TEST_P(HashOfDepth, differs_where_rows_or_texels_change_places) {
  texels_[1] = std::byte{1};
  const PictureHash first = hash();
  std::swap(texels_[1], texels_[texel_bytes() + 1]);
  const PictureHash beside = hash();
  std::swap(texels_[texel_bytes() + 1], texels_[width * texel_bytes() + 1]);
  const PictureHash above = hash();
  EXPECT_NE(first, beside);
  EXPECT_NE(first, above);
  EXPECT_NE(beside, above);
}

TEST_P(HashOfDepth, sees_only_the_stencil_bits_that_are_asked_for) {
  if (!has_stencil()) return;
  const PictureHash none = hash(0), low = hash(0x0f);
  texels_[texel_bytes() + stencil_byte()] ^= std::byte{0x01};
  EXPECT_EQ(hash(0), none);
  EXPECT_NE(hash(0x0f), low);
  texels_[texel_bytes() + stencil_byte()] ^= std::byte{0x11};
  EXPECT_EQ(hash(0x0f), low);
}

TEST_P(HashOfDepth, ignores_undefined_bits) {
  if (GetParam() != DepthFormat::d32f_s8) return;
  const PictureHash before = hash(0xff);
  for (size_t byte = 5; byte < 8; ++byte) texels_[byte] ^= std::byte{0xff};
  EXPECT_EQ(hash(0xff), before);
}

INSTANTIATE_TEST_SUITE_P(, HashOfDepth,
                         testing::Values(DepthFormat::d16, DepthFormat::d24, DepthFormat::d24s8, DepthFormat::d32f,
                                         DepthFormat::d32f_s8));

TEST(HashOfRows, DiffersWithEveryByte) {
  constexpr size_t row_bytes = 8 * 5 + 3;
  Executor executor(2);
  std::vector<std::byte> texels(3 * row_bytes, std::byte{7});
  const PictureHash before = hash_rows(executor, texels, 3);
  for (std::byte& byte : texels) {
    byte ^= std::byte{1};
    EXPECT_NE(hash_rows(executor, texels, 3), before) << &byte - texels.data();
    byte ^= std::byte{1};
  }
  EXPECT_EQ(hash_rows(executor, texels, 3), before);
}

}  // namespace
}  // namespace sideray::rt::picture_hash_test
