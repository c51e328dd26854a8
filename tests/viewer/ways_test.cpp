// The ways of drawing that the window compares.
#include "viewer/drawing/ways.h"

#include <gtest/gtest.h>

namespace sideray::tests::ways_test {
namespace {

using namespace viewer;

// Pictures have light that bounces by default, so the truth beside them has it too.
TEST(Ways, ReferencesFollowPathsUnlessThePanelSaysOtherwise) {
  Options panel = Options::create().value();
  EXPECT_EQ(options_of(Way::reference, panel)["bounces"], "unlimited");
  EXPECT_EQ(options_of(Way::reference, panel).render().reference->bounces, 0u);
  panel.set("bounces", "2");
  EXPECT_EQ(options_of(Way::reference, panel)["bounces"], "2");
}

}  // namespace
}  // namespace sideray::tests::ways_test
