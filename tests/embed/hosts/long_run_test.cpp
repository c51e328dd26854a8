// Draws thousands of small frames with a moving camera, moving glass, a resized target, and all kinds of inputs in
// turn. Sideray's heap, OpenGL objects and file descriptors must not grow. Resident memory includes the driver's, and
// has a bound of its own.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "embed/faults/failing_gl.h"
#include "embed/hosts/own_heap.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests {
namespace {

// Sanitizers hold freed memory, to find its use.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool holds_freed_memory = true;
#else
constexpr bool holds_freed_memory = false;
#endif

struct Usage {
  long resident_kib = 0;
  OwnHeap::Use heap;
  size_t objects = 0, files = 0;
};

class LongRun : public testing::Test {
 protected:
  static constexpr int frames_each = 5;  // of one kind of inputs
  static int cycle() { return frames_each * static_cast<int>(SmallHost::cases().size()); }

  // Returns the bound. NVIDIA's driver grows while our counts stay: by 30 MiB in 20,100 frames, 26 of them in the first
  // 8,000 and 2 in the last 2,000. Mesa's stays within our bound.
  long resident_bound_kib() {
    const bool is_nvidia = host_.context().info().renderer.find("NVIDIA") != std::string::npos;
    return is_nvidia ? 32 * 1024 : 4096;
  }

  // Runs the cycles. Any free thread takes work, so that a thread may allocate its scratch memory, 0.6 MB in 75 blocks,
  // as late as after 12,000 frames, when it has first seen all kinds. A single thread has it after the first cycle.
  void run(int cycles, uint32_t threads, OwnHeap::Use bound) {
    sideray_tracer_desc desc = sideray_tracer_defaults();
    desc.threads = threads;
    const Tracer tracer = Tracer::create(host_.scene(), desc).value();
    const sideray_host_gl loader{sizeof(loader), FailingGl::get_proc_address, &counted_};
    ASSERT_EQ(sideray_service_create(tracer.get(), &loader, &service_, nullptr), SIDERAY_OK);
    Usage warm;
    for (int i = 0; i < cycles && !HasFailure(); ++i) {
      for (int frame = 0; frame < cycle() && !HasFailure(); ++frame) {
        draw(i * cycle() + frame);
        most_objects_ = std::max(most_objects_, counted_.alive_count());
      }
      if (i == cycles / 4) settle(), warm = usage();
      if (cycles > 100 && i % (cycles / 10) == 0) std::printf("cycle %d: %s\n", i, text_of(usage()).c_str());
    }
    settle();
    const Usage end = usage();
    std::printf("%d frames, %d of them delivered; after warm-up: %s; at the end: %s\n", cycles * cycle(), delivered_,
                text_of(warm).c_str(), text_of(end).c_str());
    // Ours.
    EXPECT_LE(end.heap.bytes, warm.heap.bytes + bound.bytes);
    EXPECT_LE(end.heap.blocks, warm.heap.blocks + bound.blocks);
    // A place in the ring holds up to this many objects more or less, by the kinds of inputs that it has had.
    EXPECT_LE(end.objects, warm.objects + 8);
    EXPECT_EQ(end.files, warm.files);
    // Ours and the driver's together.
    EXPECT_LE(holds_freed_memory ? 0 : end.resident_kib - warm.resident_kib, resident_bound_kib());
    sideray_service_destroy(service_);
    EXPECT_EQ(counted_.alive_count(), 0u);
    EXPECT_EQ(host_.context().take_errors(), std::vector<std::string>{});
  }

 private:
  // Draws with answers one frame late, except every seventh; cancels some frames.
  void draw(int number) {
    const SmallHost::Case& c = SmallHost::cases()[static_cast<size_t>(number % cycle() / frames_each)];
    move(number);
    FrameInputs in = host_.inputs();
    in.frame.source.framebuffer = framebuffer_.id();
    c.ask(host_, in);
    if (in.layers) in.layers->float_ids = 0;  // the program reads integers
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
    now.resident_kib = pages * sysconf(_SC_PAGESIZE) / 1024;
    now.heap = heap_.use();
    now.objects = most_objects_;
    const std::filesystem::directory_iterator files("/proc/self/fd");
    now.files = static_cast<size_t>(std::distance(begin(files), end(files)));
    return now;
  }

  static std::string text_of(const Usage& usage) {
    return std::to_string(usage.heap.bytes) + " bytes in " + std::to_string(usage.heap.blocks) +
           " blocks of ours, at most " + std::to_string(usage.objects) + " OpenGL objects, " +
           std::to_string(usage.files) + " files, " + std::to_string(usage.resident_kib) + " KiB resident";
  }

  OwnHeap heap_;
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

// Two threads: the scratch memory of one may come after the warm-up, while that of fifteen would hide a leak.
TEST_F(LongRun, HundredsOfFramesGrowNothing) {
  run(4, 2, {.bytes = 3 << 19, .blocks = 96});
}

TEST_F(SlowLongRun, TwentyThousandFramesGrowNothing) {
  run(20000 / cycle() + 1, 1, {.bytes = 1 << 17, .blocks = 16});
}

}  // namespace
}  // namespace sideray::tests
