// The watchdog over calls that may not return.
#include "viewer/base/watchdog.h"

#include <gtest/gtest.h>

#include <atomic>

namespace sideray::tests::watchdog_test {
namespace {

using namespace std::chrono_literals;
using viewer::Watchdog;

void wait_for(const std::atomic<int>& count) {
  for (int i = 0; i < 5000 && count == 0; ++i) std::this_thread::sleep_for(1ms);
}

TEST(Watchdog, ExpiresOnceDuringACallThatDoesNotReturn) {
  std::atomic<int> expired = 0;
  Watchdog watchdog(20ms, [&] { ++expired; });
  {
    const Watchdog::Watch watch(watchdog);
    wait_for(expired);
    std::this_thread::sleep_for(60ms);
  }
  EXPECT_EQ(expired, 1);
}

TEST(Watchdog, LeavesShortCallsAndTheTimeBetweenThem) {
  std::atomic<int> expired = 0;
  Watchdog watchdog(2000ms, [&] { ++expired; });
  Watchdog other(10ms, [&] { ++expired; });
  for (int i = 0; i < 5; ++i) {
    const Watchdog::Watch watch(watchdog);
    std::this_thread::sleep_for(2ms);
  }
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(expired, 0);
}

TEST(Watchdog, CountsAnewForANestedCall) {
  std::atomic<int> expired = 0;
  Watchdog watchdog(10ms, [&] { ++expired; });
  const Watchdog::Watch outer(watchdog);
  wait_for(expired);
  const Watchdog::Watch inner(watchdog);
  expired = 0;
  wait_for(expired);
  EXPECT_EQ(expired, 1);
}

}  // namespace
}  // namespace sideray::tests::watchdog_test
