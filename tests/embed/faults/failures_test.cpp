// Simulates drivers that run out of memory, give no names, never reach a fence or lose the context, at every place in
// turn: the call fails, the host finds no OpenGL error, the last good outputs and the next frame are unchanged, nothing
// leaks.
#include <gmock/gmock.h>

#include <cstdlib>

#include "embed/faults/failing_gl.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests {
namespace {

using Kind = FailingGl::Failure;

class Failures : public testing::Test {
 protected:
  Failures() : host_(gl::Context::create("auto", "")), program_(host_.program()), failing_(host_.context()) {}
  ~Failures() override {
    unsetenv("SIDERAY_TRANSPORT");
    if (service_) sideray_service_destroy(service_);
    host_.context().take_errors();
  }

  void create() {
    const sideray_host_gl loader{sizeof(loader), FailingGl::get_proc_address, &failing_};
    sideray_error error{};
    ASSERT_EQ(sideray_service_create(host_.tracer(), &loader, &service_, &error), SIDERAY_OK) << error.message;
  }
  void destroy() { sideray_service_destroy(std::exchange(service_, nullptr)); }

  FrameInputs inputs(const SmallHost::Case& c, bool small) const {
    FrameInputs in = host_.inputs();
    c.ask(host_, in);
    if (small) {
      in.frame.source.width -= 8;
      in.frame.source.height -= 8;
    }
    return in;
  }
  sideray_status frame(const FrameInputs& in, sideray_error& error) {
    last_ticket_ = 0;
    const sideray_status status = submit_frame(service_, in, last_ticket_, &error);
    return status == SIDERAY_OK ? sideray_service_wait(service_, last_ticket_, -1, &error) : status;
  }
  // Holds the outputs of one kind of job: the frame's ticket and the texels.
  struct Kept {
    sideray_ticket ticket = 0;
    std::vector<uint8_t> texels;
    bool operator==(const Kept&) const = default;
  };
  // Outputs of layers, masks and reflections, each of the newest frame that finished them.
  using Outputs = std::array<Kept, 3>;
  Outputs newest() const {
    FrameOutputs out;
    newest_of_each_kind(service_, 0, out);
    const auto kept = [&](const auto& one) { return one ? Kept{one->ticket, host_.texels(*one)} : Kept{}; };
    return {kept(out.layers), kept(out.masks), kept(out.reflections)};
  }
  static bool hold_the_same(const Outputs& a, const Outputs& b) {
    return std::equal(a.begin(), a.end(), b.begin(), [](const Kept& x, const Kept& y) { return x.texels == y.texels; });
  }
  // Expects after a failed frame that each kind is of the last good frame, or was finished before the failure.
  void expect_kept_or_finished(const FrameInputs& in, const Outputs& good, const Outputs& expected) const {
    const bool has_several = in.layers.has_value() + in.masks.has_value() + in.reflections.has_value() > 1;
    const Outputs now = newest();
    for (size_t kind = 0; kind < now.size(); ++kind) {
      const bool finished = has_several && last_ticket_ != 0 && now[kind].ticket == last_ticket_;
      const bool right = finished ? now[kind].texels == expected[kind].texels : now[kind] == good[kind];
      EXPECT_TRUE(right) << "the last good outputs of kind " << kind << " changed";
    }
  }
  void expect_no_error_for_the_host() {
    EXPECT_EQ(failing_.take_error(), uint32_t{GL_NO_ERROR});
    EXPECT_EQ(host_.gl.GetError(), GLenum{GL_NO_ERROR});
  }
  // Expects that binding works, with the frame's layers or none.
  void expect_bound() {
    ASSERT_EQ(sideray_service_bind(service_, 0, program_.id(), 0, nullptr), SIDERAY_OK);
    GLint layers = -1;
    host_.gl.GetUniformiv(program_.id(), program_.uniform("sideray_layers"), &layers);
    FrameOutputs outputs;
    newest_of_each_kind(service_, 0, outputs);
    const auto& out = outputs.layers;
    EXPECT_EQ(layers, out && out->mode == SIDERAY_CACHE ? static_cast<GLint>(out->layers) : 0);
  }

  // Draws a frame in which the n-th call fails, with `before` after a good frame of another size. Returns false where
  // there is no n-th call.
  bool fails_at(const SmallHost::Case& c, Kind kind, int n, bool before, const Outputs& expected) {
    SCOPED_TRACE(testing::Message() << c.name << ", failure " << static_cast<int>(kind) << ", the " << n << "th, "
                                    << (before ? "behind a good frame" : "in the first frame"));
    failing_.fail(Kind::none);
    create();
    sideray_error error{};
    const sideray_status first = before ? frame(inputs(c, true), error) : SIDERAY_OK;
    EXPECT_EQ(first, SIDERAY_OK) << error.message;
    const Outputs good = newest();
    failing_.fail(kind, n);
    const sideray_status status = frame(inputs(c, false), error);
    const bool failed = failing_.has_failed();
    expect_no_error_for_the_host();
    failing_.fail(Kind::none);
    if (status == SIDERAY_OK) {
      EXPECT_TRUE(hold_the_same(newest(), expected));
    } else {
      EXPECT_TRUE(status == SIDERAY_OUT_OF_MEMORY || status == SIDERAY_GL_FAILED) << status << ": " << error.message;
      EXPECT_TRUE(failed) << status << ": " << error.message;
      EXPECT_NE(std::string(error.message), "");
      expect_kept_or_finished(inputs(c, false), good, expected);
      ++refused_;
    }
    expect_bound();
    EXPECT_EQ(frame(inputs(c, false), error), SIDERAY_OK) << error.message;
    EXPECT_TRUE(hold_the_same(newest(), expected)) << "the next frame";
    expect_no_error_for_the_host();
    destroy();
    EXPECT_EQ(failing_.alive_count(), 0u);
    EXPECT_EQ(failing_.unknown_deletions(), 0);
    return failed;
  }

  // Fails at every place in turn, and returns their number.
  int fail_everywhere(const char* name, Kind kind, bool before) {
    const SmallHost::Case& c = *std::find_if(SmallHost::cases().begin(), SmallHost::cases().end(),
                                             [&](const auto& each) { return std::string(each.name) == name; });
    create();
    sideray_error error{};
    EXPECT_EQ(frame(inputs(c, false), error), SIDERAY_OK) << error.message;
    const Outputs expected = newest();
    destroy();
    int n = 1;
    while (n < 300 && fails_at(c, kind, n, before, expected) && !HasFailure()) ++n;
    return n - 1;
  }

  SmallHost host_;
  gl::Program program_;
  FailingGl failing_;
  sideray_service* service_ = nullptr;
  sideray_ticket last_ticket_ = 0;
  int refused_ = 0;
};

constexpr const char* ways_to_move[] = {"copy", "persistent", "packed"};
constexpr const char* inputs_of_all_kinds[] = {
    "multisampled framebuffer",       "mask texture",          "depth texture", "composite",
    "inexact masks with a rest pose", "reflections and layers"};

TEST_F(Failures, EveryAllocation) {
  for (const char* way : ways_to_move)
    for (const char* name : inputs_of_all_kinds)
      for (const bool before : {false, true}) {
        setenv("SIDERAY_TRANSPORT", way, 1);
        EXPECT_GE(fail_everywhere(name, Kind::allocation, before), 2) << name;
      }
  EXPECT_GT(refused_, 20);
}

TEST_F(Failures, EveryMapping) {
  for (const char* way : ways_to_move)
    for (const char* name : inputs_of_all_kinds) {
      setenv("SIDERAY_TRANSPORT", way, 1);
      EXPECT_GE(fail_everywhere(name, Kind::mapping, true), 1) << name;
    }
  EXPECT_GT(refused_, 5);
}

TEST_F(Failures, EveryName) {
  for (const char* way : {"persistent", "packed"}) {
    setenv("SIDERAY_TRANSPORT", way, 1);
    for (const char* name : inputs_of_all_kinds) EXPECT_GE(fail_everywhere(name, Kind::name, true), 3) << name;
  }
  EXPECT_GT(refused_, 15);
}

TEST_F(Failures, EveryFence) {
  for (const char* way : ways_to_move)
    for (const Kind kind : {Kind::fence, Kind::waiting}) {
      setenv("SIDERAY_TRANSPORT", way, 1);
      EXPECT_GE(fail_everywhere("mask texture", kind, true), 1);
    }
  EXPECT_GE(refused_, 4);
}

TEST_F(Failures, AnythingWhereAllJobsAreRequested) {
  setenv("SIDERAY_TRANSPORT", "copy", 1);
  EXPECT_GE(fail_everywhere("everything", Kind::allocation, true), 8);
  setenv("SIDERAY_TRANSPORT", "packed", 1);
  EXPECT_GE(fail_everywhere("everything", Kind::name, true), 3);
}

TEST_F(Failures, AnythingWhileTransportIsMeasured) {
  unsetenv("SIDERAY_TRANSPORT");
  for (const Kind kind : {Kind::allocation, Kind::mapping, Kind::name, Kind::fence, Kind::waiting})
    EXPECT_GE(fail_everywhere("count in stencil", kind, false), 3);
}

TEST_F(Failures, AFenceThatNeverComesHangsNothing) {
  for (const char* way : {"copy", "persistent", "packed", ""}) {
    setenv("SIDERAY_TRANSPORT", way, 1);
    create();
    failing_.fail(Kind::never);
    const FrameInputs in = inputs(SmallHost::cases().front(), false);
    sideray_ticket tickets[3] = {}, more = 0;
    sideray_error error{};
    for (sideray_ticket& ticket : tickets)
      ASSERT_EQ(submit_frame(service_, in, ticket, &error), SIDERAY_OK) << error.message;
    EXPECT_EQ(submit_frame(service_, in, more), SIDERAY_NOT_READY);
    EXPECT_EQ(sideray_service_wait(service_, tickets[0], 20, nullptr), SIDERAY_NOT_READY);
    EXPECT_EQ(sideray_service_advance(service_, nullptr), SIDERAY_OK);
    // A cancelled frame frees its place.
    EXPECT_EQ(sideray_service_cancel(service_, tickets[1], nullptr), SIDERAY_OK);
    EXPECT_EQ(sideray_service_wait(service_, tickets[1], 20, nullptr), SIDERAY_CANCELLED);
    EXPECT_EQ(submit_frame(service_, in, more), SIDERAY_OK);
    expect_bound();
    expect_no_error_for_the_host();
    destroy();
    EXPECT_EQ(failing_.alive_count(), 0u);
    failing_.fail(Kind::none);
  }
}

TEST_F(Failures, ALostContextIsToldAndAbandoned) {
  const FrameInputs in = inputs(SmallHost::cases().front(), false);
  for (const char* way : {"persistent", "packed"}) {
    setenv("SIDERAY_TRANSPORT", way, 1);
    int n = 1;
    for (bool struck = true; struck && n < 100; ++n) {
      SCOPED_TRACE(n);
      create();
      failing_.fail(Kind::lost, n);
      sideray_error error{};
      const sideray_status status = frame(in, error);
      struck = failing_.has_failed();
      if (struck) {
        EXPECT_TRUE(status == SIDERAY_OK || status == SIDERAY_GL_FAILED) << status << ": " << error.message;
        EXPECT_EQ(frame(in, error), SIDERAY_GL_FAILED);
        EXPECT_NE(std::string(error.message).find("abandon_context"), std::string::npos) << error.message;
        failing_.forbid_calls(true);
        sideray_service_abandon_context(service_);
        sideray_ticket ticket = 0;
        EXPECT_EQ(submit_frame(service_, in, ticket, &error), SIDERAY_GL_FAILED);
        EXPECT_EQ(sideray_service_bind(service_, 0, program_.id(), 0, &error), SIDERAY_GL_FAILED);
      }
      destroy();
      EXPECT_EQ(failing_.forbidden_calls(), 0);
      failing_.forbid_calls(false);
      failing_.fail(Kind::none);
      while (host_.gl.GetError() != GL_NO_ERROR) {
      }
    }
    EXPECT_GT(n, 5);
  }
  // Scene and tracer outlive the service.
  host_.gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
  create();
  sideray_error error{};
  EXPECT_EQ(frame(in, error), SIDERAY_OK) << error.message;
  EXPECT_FALSE(newest()[0].texels.empty());
}

// The worker may be tracing into mapped memory.
TEST_F(Failures, AbandonedWhileFramesAreInFlight) {
  for (const char* way : ways_to_move) {
    setenv("SIDERAY_TRANSPORT", way, 1);
    create();
    for (const SmallHost::Case& c : SmallHost::cases()) {
      const FrameInputs in = inputs(c, false);
      sideray_ticket ticket = 0;
      submit_frame(service_, in, ticket);
      sideray_service_advance(service_, nullptr);
    }
    failing_.forbid_calls(true);
    sideray_service_abandon_context(service_);
    destroy();
    EXPECT_EQ(failing_.forbidden_calls(), 0);
    failing_.forbid_calls(false);
  }
}

}  // namespace
}  // namespace sideray::tests
