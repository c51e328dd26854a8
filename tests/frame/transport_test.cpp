// Tests the storage and upload of layers on whole frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

// The way of uploads is chosen by measurements, so it must not change the picture.
TEST(Transport, IsNotSeenInThePicture) {
  const scenes::Content content = scenes::generate("panes", {});
  for (const sideray_translucency translucency : {SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_TRANSLUCENCY_RAYTRACED}) {
    tests::Setup setup{.width = 160, .height = 90, .translucency = translucency, .samples = 3};
    std::map<std::string, std::vector<float>> copied;
    for (const char* way : {"copy", "persistent", "packed", ""}) {
      setenv("SIDERAY_TRANSPORT", way, 1);
      const Frame frame = render(content, setup);
      if (copied.empty()) copied = frame.planes;
      EXPECT_EQ(frame.planes, copied) << way;
    }
    unsetenv("SIDERAY_TRANSPORT");
  }
}

}  // namespace
}  // namespace sideray::tests
