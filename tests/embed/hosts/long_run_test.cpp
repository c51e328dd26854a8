// Thousands of small frames: a camera that moves, glass that moves, a target that is resized, all kinds of inputs in
// turn. Memory, OpenGL objects and file descriptors must not grow.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "embed/faults/failing_gl.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests {
namespace {

// Sanitizers keep what was freed, to find those who use it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool holds_freed_memory = true;
#else
constexpr bool holds_freed_memory = false;
#endif

struct Usage {
  long kib = 0;
  size_t objects = 0, files = 0;
};

class LongRun : public testing::Test {
 protected:
  static constexpr int frames_each = 5;  // of one kind of inputs
  static int cycle() { return frames_each * static_cast<int>(SmallHost::cases().size()); }

  void run(int cycles, long bound_kib) {
    const sideray_host_gl loader{sizeof(loader), FailingGl::get_proc_address, &counted_};
    ASSERT_EQ(sideray_service_create(host_.tracer(), &loader, &service_, nullptr), SIDERAY_OK);
    Usage warm;
    for (int i = 0; i < cycles && !HasFailure(); ++i) {
      for (int frame = 0; frame < cycle() && !HasFailure(); ++frame) {
        draw(i * cycle() + frame);
        most_objects_ = std::max(most_objects_, counted_.alive_count());
      }
      if (i == 1) settle(), warm = usage();
      if (cycles > 100 && i % (cycles / 10) == 0) std::printf("cycle %d: %ld KiB resident\n", i, usage().kib);
    }
    settle();
    const Usage end = usage();
    std::printf(
        "%d frames, %d of them delivered: %ld KiB resident after warm-up, %ld at the end; at most %zu objects, %zu; "
        "%zu files, "
        "%zu\n",
        cycles * cycle(), delivered_, warm.kib, end.kib, warm.objects, end.objects, warm.files, end.files);
    EXPECT_LE(holds_freed_memory ? 0 : end.kib - warm.kib, bound_kib);
    // A place in the ring holds up to that many more or less, by the kinds of inputs that it has met.
    EXPECT_LE(end.objects, warm.objects + 8);
    EXPECT_EQ(end.files, warm.files);
    sideray_service_destroy(service_);
    EXPECT_EQ(counted_.alive_count(), 0u);
    EXPECT_EQ(host_.context().take_errors(), std::vector<std::string>{});
  }

 private:
  // One frame late, but for every seventh; some are cancelled.
  void draw(int number) {
    const SmallHost::Case& c = SmallHost::cases()[static_cast<size_t>(number % cycle() / frames_each)];
    move(number);
    FrameInputs in = host_.inputs();
    in.frame.source.framebuffer = framebuffer_.id();
    c.ask(host_, in);
    SmallHost::set_view(in, SmallHost::clip_from_world(0.2 * std::sin(0.1 * number)));
    if (number % 3 == 0) {
      in.frame.source.width -= number % 11;
      in.frame.source.height -= number % 7;
    }
    in.frame.continues = number % 4 != 0;
    in.frame.seed = static_cast<uint32_t>(number);
    sideray_error error{};
    sideray_ticket ticket = 0;
    ASSERT_EQ(submit_frame(service_, in, ticket, &error), SIDERAY_OK) << error.message;
    const bool cancels = number % 13 == 0;
    if (cancels) sideray_service_cancel(service_, ticket, nullptr);
    const sideray_status waited = last_ ? sideray_service_wait(service_, last_, -1, &error) : SIDERAY_OK;
    ASSERT_EQ(waited, SIDERAY_OK) << error.message;
    if (number % 7 == 0 || cancels) {
      ASSERT_EQ(sideray_service_wait(service_, ticket, -1, &error), cancels ? SIDERAY_CANCELLED : SIDERAY_OK)
          << error.message;
      ticket = 0;
    }
    ASSERT_EQ(sideray_service_advance(service_, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_service_bind(service_, 0, program_.id(), 0, &error), SIDERAY_OK) << error.message;
    last_ = ticket;
    delivered_ += !cancels;
    ASSERT_EQ(host_.gl.GetError(), GLenum{GL_NO_ERROR});
  }

  void move(int number) {
    const double pane[12] = {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9, 0.1 * std::sin(0.07 * number), 0, 1};
    host_.scene().move_instance(host_.pane(), pane);
    host_.scene().commit();
    const gl::Functions& gl = host_.gl;
    if (number % 10 == 0) {
      gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
      const int more = number / 10 % 5 * 9;
      gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, SmallHost::width + more, SmallHost::height + more);
      gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
      gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }

  void settle() {
    if (last_ != 0) sideray_service_wait(service_, std::exchange(last_, 0), -1, nullptr);
  }

  Usage usage() const {
    Usage now;
    long pages = 0;
    std::ifstream statm("/proc/self/statm");
    statm >> pages >> pages;
    now.kib = pages * sysconf(_SC_PAGESIZE) / 1024;
    now.objects = most_objects_;
    const std::filesystem::directory_iterator files("/proc/self/fd");
    now.files = static_cast<size_t>(std::distance(begin(files), end(files)));
    return now;
  }

  SmallHost host_{gl::Context::create("auto", "")};
  gl::Program program_ = host_.program();
  gl::Framebuffer framebuffer_{host_.gl};
  gl::Renderbuffer depth_{host_.gl};
  FailingGl counted_{host_.context()};
  sideray_service* service_ = nullptr;
  sideray_ticket last_ = 0;
  int delivered_ = 0;
  size_t most_objects_ = 0;
};

using SlowLongRun = LongRun;

TEST_F(LongRun, HundredsOfFramesGrowNothing) {
  run(4, 4096);
}

TEST_F(SlowLongRun, TwentyThousandFramesGrowNothing) {
  run(20000 / cycle() + 1, 4096);
}

}  // namespace
}  // namespace sideray::tests
