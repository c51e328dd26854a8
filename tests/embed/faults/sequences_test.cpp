// Runs random sequences of the service's calls, valid and invalid, with failing drivers, lost contexts, calls from
// threads without a context, and edits of the scene. A failed call must say why and change nothing, tickets must grow,
// outputs must never get older, the host must find no OpenGL error, nothing may leak, and a new service's frame must
// keep its bits. SIDERAY_SEQUENCES=FIRST:COUNT runs other seeds than the CI's.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <thread>

#include "embed/faults/failing_gl.h"
#include "embed/hosts/small_host.h"
#include "fuzz/random.h"

namespace sideray::tests::sequences_test {
namespace {

using Kind = FailingGl::Failure;

constexpr uint32_t views = 3;
constexpr size_t places = 3;  // for frames in flight, a view

// Returns an invalid value of an enum, which C hosts may pass.
template <typename Enum>
Enum no_value(int32_t number) {
  Enum value{};
  static_assert(sizeof(value) == sizeof(number));
  std::memcpy(&value, &number, sizeof(value));
  return value;
}

// Holds a context and a host.
struct World {
  SmallHost host{gl::Context::create("auto", "")};
  gl::Program program = host.program();
  FailingGl failing{host.context()};
  ~World() { host.context().take_errors(); }
};

class Sequences : public testing::Test {
 protected:
  Sequences() : world_(std::make_unique<World>()) {}
  ~Sequences() override { destroy(); }

  void run(uint64_t seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    random_ = fuzz::Random(seed);
    log_.clear();
    create();
    for (uint32_t i = 1 + random_.below(40); i > 0 && !HasFailure(); --i) call();
    destroy();
    EXPECT_EQ(world_->failing.alive_count(), 0u);
    EXPECT_EQ(world_->failing.unknown_deletions(), 0);
    expect_frame_as_ever();
    if (HasFailure()) ADD_FAILURE() << "the calls and their answers:\n" << log_;
  }

  // Returns the frame of the first case from a new service.
  std::vector<uint8_t> frame_of_new_service() {
    create();
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(service_, world_->host.inputs(), ticket, &error), SIDERAY_OK) << error.message;
    EXPECT_EQ(sideray_service_wait(service_, ticket, -1, &error), SIDERAY_OK) << error.message;
    sideray_layer_outputs out{};
    out.size = sizeof(out);
    EXPECT_EQ(sideray_service_layers(service_, 0, &out, &error), SIDERAY_OK) << error.message;
    std::vector<uint8_t> texels = world_->host.texels(out);
    destroy();
    return texels;
  }

  std::vector<uint8_t> expected_;
  uint64_t calls_ = 0, refused_ = 0, frames_ = 0, lost_ = 0;

 private:
  struct Ticket {
    sideray_ticket ticket;
    uint32_t view;
    bool is_open = true;    // may be in flight
    bool may_fail = false;  // OpenGL failed while it was in flight, or it was cancelled
  };

  void create() {
    const sideray_host_gl loader{sizeof(loader), FailingGl::get_proc_address, &world_->failing};
    sideray_error error{};
    ASSERT_EQ(sideray_service_create(world_->host.tracer(), &loader, &service_, &error), SIDERAY_OK) << error.message;
    tickets_.clear();
    newest_ = {};
    last_ = 0;
  }
  void destroy() {
    if (service_) sideray_service_destroy(std::exchange(service_, nullptr));
  }
  void note(const char* call, uint64_t what, sideray_status status) {
    log_ += std::string(call) + ' ' + std::to_string(what) + ": " + std::to_string(status) + '\n';
  }
  void expect_frame_as_ever() { EXPECT_EQ(SmallHost::difference(frame_of_new_service(), expected_), ""); }
  void expect_no_error_for_the_host() {
    EXPECT_EQ(world_->failing.take_error(), uint32_t{GL_NO_ERROR});
    EXPECT_EQ(world_->host.gl.GetError(), GLenum{GL_NO_ERROR});
  }
  void expect_refused(sideray_status status, const sideray_error& error, const char* what) {
    EXPECT_LT(status, SIDERAY_OK) << what;
    EXPECT_EQ(error.status, status) << what;
    EXPECT_NE(std::string(error.message), "") << what;
    ++refused_;
  }

  void call() {
    using Call = void (Sequences::*)();
    static constexpr Call calls[] = {&Sequences::submit,  &Sequences::submit,     &Sequences::submit,
                                     &Sequences::wait,    &Sequences::wait,       &Sequences::submit_wrong,
                                     &Sequences::advance, &Sequences::cancel,     &Sequences::ask,
                                     &Sequences::ask,     &Sequences::ask_wrong,  &Sequences::bind,
                                     &Sequences::move,    &Sequences::edit_wrong, &Sequences::from_elsewhere,
                                     &Sequences::fail_gl, &Sequences::anew,       &Sequences::create_wrong};
    (this->*random_.of(calls))();
    ++calls_;
    expect_no_error_for_the_host();
    if (random_.one_in(60)) lose_context();
  }

  FrameInputs valid_inputs() {
    FrameInputs in = world_->host.inputs();
    const SmallHost::Case& chosen = random_.of(SmallHost::cases());
    chosen.ask(world_->host, in);
    in.frame.view_id = random_.below(views);
    in.frame.seed = random_.below(4);
    in.frame.continues = random_.one_in(2);
    if (random_.one_in(4)) in.frame.source.width -= 8, in.frame.source.height -= 8;
    if (random_.one_in(8)) in.frame.deadline_ms = 0.01f;
    return in;
  }
  size_t open_count(uint32_t view) const {
    return static_cast<size_t>(
        std::count_if(tickets_.begin(), tickets_.end(), [&](const Ticket& t) { return t.is_open && t.view == view; }));
  }

  void submit() {
    const FrameInputs in = valid_inputs();
    sideray_ticket ticket = 0;
    sideray_error error{};
    const sideray_status status = submit_frame(service_, in, ticket, &error);
    note(("view " + std::to_string(in.frame.view_id) + ", submit").c_str(), ticket, status);
    if (status == SIDERAY_NOT_READY) {
      EXPECT_GE(open_count(in.frame.view_id), places);
      return;
    }
    ASSERT_EQ(status, SIDERAY_OK) << error.message;
    EXPECT_GT(ticket, last_);
    last_ = ticket;
    tickets_.push_back({ticket, in.frame.view_id});
    ++frames_;
  }

  void submit_wrong() {
    FrameInputs in = valid_inputs();
    if (!in.layers) in.layers = sideray_layer_inputs_defaults();
    const uint32_t which = random_.below(14);
    note("mistake", which, SIDERAY_OK);
    switch (which) {
      case 0:
        in.frame.view_id = SIDERAY_MAX_VIEWS + random_.below(1000);
        break;
      case 1:
        in.frame.source.width = -static_cast<int32_t>(random_.below(3));
        break;
      case 2:
        in.frame.source.height = SmallHost::height + 1000;
        break;
      case 3:
        in.frame.source = world_->host.inputs().frame.source, in.frame.source.framebuffer = 4711;
        break;
      case 4:
        in.layers->max_layers = 65 + random_.below(100);
        break;
      case 5:
        in.frame.view.clip_from_world[random_.below(16)] = std::nan("");
        break;
      case 6:
        in.frame.view.world_from_clip[random_.below(16)] = HUGE_VAL;
        break;
      case 7:
        in.layers->size = random_.below(sizeof(size_t));
        break;
      case 8:
        in.layers.reset(), in.masks.reset(), in.reflections.reset();
        break;
      case 9:
        in.frame.size = 1;
        break;
      case 10:
        in.frame.source.mask = no_value<sideray_mask_source>(99);
        break;
      case 11:
        in.layers->mode = no_value<sideray_service_mode>(7);
        break;
      case 12:
        in.frame.deadline_ms = -1.0f;
        break;
      default:
        in.frame.source.depth_texture = 4711;
        break;
    }
    sideray_ticket ticket = 4712;
    sideray_error error{};
    const sideray_status status = submit_frame(service_, in, ticket, &error);
    // A view without a free place may say so before it checks the inputs.
    if (status == SIDERAY_NOT_READY) return;
    expect_refused(status, error, ("submit, mistake " + std::to_string(which)).c_str());
    // A missing texture is found by OpenGL, where textures have no size query, or by the reading of its stencil.
    const bool is_right = status == SIDERAY_INVALID_ARGUMENT || which == 13;
    EXPECT_TRUE(is_right) << which << ": " << status << ", " << error.message;
    EXPECT_EQ(ticket, 4712u) << "a refused call has written a ticket";
  }

  Ticket* some_ticket() {
    return tickets_.empty() ? nullptr : &tickets_[tickets_.size() - 1 - random_.below(std::min<uint32_t>(6, count()))];
  }
  uint32_t count() const { return static_cast<uint32_t>(tickets_.size()); }

  void wait() {
    Ticket* const ticket = some_ticket();
    if (!ticket) return;
    const int32_t timeout = random_.pick({-1, -1, 0, 1});
    sideray_error error{};
    const sideray_status status = sideray_service_wait(service_, ticket->ticket, timeout, &error);
    note("wait", ticket->ticket, status);
    if (status == SIDERAY_NOT_READY) {
      EXPECT_GE(timeout, 0);
      EXPECT_TRUE(ticket->is_open) << "a finished frame is in flight again";
      return;
    }
    if (status == SIDERAY_OK || status == SIDERAY_CANCELLED) ticket->is_open = false;
    if (status != SIDERAY_OK) {
      EXPECT_TRUE(ticket->may_fail) << status << ": " << error.message;
      expect_refused(status, error, "wait");
      ticket->may_fail = true;
    }
  }

  void cancel() {
    Ticket* const ticket = some_ticket();
    if (!ticket) return;
    sideray_error error{};
    const sideray_status status = sideray_service_cancel(service_, ticket->ticket, &error);
    note("cancel", ticket->ticket, status);
    if (status == SIDERAY_OK)
      EXPECT_TRUE(ticket->is_open) << "what was finished was cancelled";
    else
      expect_refused(status, error, "cancel");
    ticket->may_fail = true;
  }

  void advance() {
    sideray_error error{};
    EXPECT_EQ(sideray_service_advance(service_, &error), SIDERAY_OK) << error.message;
  }

  template <typename Outputs>
  void expect_no_way_back(uint32_t view, size_t kind,
                          sideray_status (*read)(sideray_service*, uint32_t, Outputs*, sideray_error*)) {
    Outputs out{};
    out.size = sizeof(out);
    sideray_error error{};
    const sideray_status status = read(service_, view, &out, &error);
    sideray_ticket& newest = newest_[view][kind];
    if (status == SIDERAY_NOT_READY) {
      EXPECT_EQ(newest, 0u) << "outputs are gone, kind " << kind;
      return;
    }
    ASSERT_EQ(status, SIDERAY_OK) << error.message;
    EXPECT_GE(out.ticket, newest) << "outputs went back, kind " << kind;
    EXPECT_LE(out.ticket, last_);
    EXPECT_TRUE(std::any_of(tickets_.begin(), tickets_.end(), [&](const Ticket& t) {
      return t.ticket == out.ticket && t.view == view;
    })) << "outputs of no frame of the view";
    newest = out.ticket;
    if (random_.one_in(8)) world_->host.texels(out);  // expects textures
  }

  void ask() {
    for (uint32_t view = 0; view < views; ++view) {
      expect_no_way_back<sideray_layer_outputs>(view, 0, sideray_service_layers);
      expect_no_way_back<sideray_mask_outputs>(view, 1, sideray_service_masks);
      expect_no_way_back<sideray_reflection_outputs>(view, 2, sideray_service_reflections);
    }
    if (const Ticket* ticket = some_ticket()) {
      sideray_frame_stats stats{};
      stats.size = sizeof(stats);
      sideray_error error{};
      const sideray_status status = sideray_service_stats(service_, ticket->ticket, &stats, &error);
      if (status == SIDERAY_OK) {
        EXPECT_LE(stats.pixels_masked, stats.pixels_total);
        EXPECT_LE(stats.pixels_total, uint64_t{SmallHost::width} * SmallHost::height);
      }
      uint32_t jobs = 0;
      sideray_service_finished_jobs(service_, ticket->ticket, &jobs, &error);
      EXPECT_LT(jobs, 8u);
    }
  }

  void ask_wrong() {
    sideray_error error{};
    sideray_layer_outputs out{};
    uint32_t jobs = 0;
    const sideray_ticket unknown = last_ + 1 + random_.below(1000);
    switch (random_.below(7)) {
      case 0:
        expect_refused(sideray_service_wait(service_, unknown, 0, &error), error, "wait");
        break;
      case 1:
        expect_refused(sideray_service_cancel(service_, unknown, &error), error, "cancel");
        break;
      case 2:
        expect_refused(sideray_service_finished_jobs(service_, unknown, &jobs, &error), error, "jobs");
        break;
      case 3:
        expect_refused(sideray_service_layers(service_, 0, &out, &error), error, "layers of no size");
        break;
      case 4:
        out.size = sizeof(out);
        expect_refused(sideray_service_layers(service_, SIDERAY_MAX_VIEWS, &out, &error), error, "layers of no view");
        break;
      case 5:
        expect_refused(sideray_service_bind(service_, 0, random_.one_in(2) ? 0 : 4711, 0, &error), error, "bind");
        break;
      default:
        expect_refused(sideray_service_wait(service_, 0, -1, &error), error, "wait for none");
        break;
    }
  }

  void bind() {
    sideray_error error{};
    const sideray_status status =
        sideray_service_bind(service_, random_.below(views), world_->program.id(), random_.below(8), &error);
    // The program reads integers, and some frames have floats.
    const bool other_ids = std::strstr(error.message, "float_ids") != nullptr;
    EXPECT_EQ(status, other_ids ? SIDERAY_INVALID_ARGUMENT : SIDERAY_OK) << error.message;
  }

  // Moves an instance there and back, so that the scene is unchanged in the end.
  void move() {
    const double there[12] = {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9, random_.between(-0.5, 0.5), 0, 1.0};
    const double home[12] = {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9, 0, 0, 1.0};
    const sideray_instance pane = world_->host.pane();
    sideray_error error{};
    sideray_scene* const scene = world_->host.scene().get();
    ASSERT_EQ(sideray_scene_move_instances(scene, &pane, 1, there, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_scene_commit(scene, &error), SIDERAY_OK) << error.message;
    submit();
    ASSERT_EQ(sideray_scene_move_instances(scene, &pane, 1, home, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_scene_commit(scene, &error), SIDERAY_OK) << error.message;
  }

  void edit_wrong() {
    const sideray_instance none = 4711;
    const double nowhere[12] = {};
    sideray_error error{};
    sideray_scene* const scene = world_->host.scene().get();
    expect_refused(sideray_scene_remove_instances(scene, &none, 1, &error), error, "remove");
    expect_refused(sideray_scene_move_instances(scene, &none, 1, nowhere, &error), error, "move");
  }

  void from_elsewhere() {
    FrameInputs in = valid_inputs();
    const uint32_t which = random_.below(3);
    sideray_error error{};
    sideray_status status = SIDERAY_OK;
    sideray_ticket ticket = 0;
    std::thread([&] {
      if (which == 0) status = submit_frame(service_, in, ticket, &error);
      if (which == 1) status = sideray_service_advance(service_, &error);
      if (which == 2) status = sideray_service_bind(service_, 0, world_->program.id(), 0, &error);
    }).join();
    // With nothing in flight the call needs no OpenGL.
    const bool has_nothing_to_do = status == SIDERAY_NOT_READY || (which == 1 && status == SIDERAY_OK);
    if (!has_nothing_to_do) expect_refused(status, error, "a thread without a context");
  }

  // A frame in which OpenGL fails at a random place.
  void fail_gl() {
    const Kind kinds[] = {Kind::allocation, Kind::mapping, Kind::name, Kind::fence, Kind::waiting};
    const Kind kind = random_.of(kinds);
    const uint32_t n = 1 + random_.below(12);
    world_->failing.fail(kind, static_cast<int>(n));
    for (Ticket& ticket : tickets_) ticket.may_fail = true;
    const FrameInputs in = valid_inputs();
    sideray_ticket ticket = 0;
    sideray_error error{};
    sideray_status status = submit_frame(service_, in, ticket, &error);
    note(("failure " + std::to_string(static_cast<int>(kind)) + ", the " + std::to_string(n) + "th, submit").c_str(),
         ticket, status);
    if (status == SIDERAY_OK) {
      last_ = ticket;
      tickets_.push_back({ticket, in.frame.view_id, true, true});
      status = sideray_service_wait(service_, ticket, -1, &error);
      note("wait, a driver that fails", ticket, status);
      // This call may report the failure of an earlier frame.
      if (status == SIDERAY_OK || status == SIDERAY_CANCELLED) tickets_.back().is_open = false;
    }
    if (status < SIDERAY_OK) {
      EXPECT_TRUE(world_->failing.has_failed()) << status << ": " << error.message;
      expect_refused(status, error, "a driver that fails");
    }
    world_->failing.take_error();
    world_->failing.fail(Kind::none);
  }

  void anew() {
    destroy();
    EXPECT_EQ(world_->failing.alive_count(), 0u);
    create();
  }

  void create_wrong() {
    sideray_error error{};
    sideray_service* made = nullptr;
    const sideray_host_gl small{1, FailingGl::get_proc_address, &world_->failing};
    const sideray_host_gl empty{sizeof(empty), nullptr, nullptr};
    expect_refused(sideray_service_create(world_->host.tracer(), random_.one_in(2) ? &small : &empty, &made, &error),
                   error, "create");
    EXPECT_EQ(made, nullptr);
  }

  // Loses the context with frames in flight: OpenGL must not be called after that.
  void lose_context() {
    note("lost", 0, SIDERAY_OK);
    world_->failing.fail(Kind::lost, 1 + static_cast<int>(random_.below(10)));
    sideray_ticket ticket = 0;
    sideray_error error{};
    submit_frame(service_, valid_inputs(), ticket, &error);
    sideray_service_advance(service_, &error);
    world_->failing.forbid_calls(true);
    sideray_service_abandon_context(service_);
    expect_refused(submit_frame(service_, valid_inputs(), ticket, &error), error, "submit without a context");
    expect_refused(sideray_service_bind(service_, 0, world_->program.id(), 0, &error), error, "bind without a context");
    destroy();
    EXPECT_EQ(world_->failing.forbidden_calls(), 0);
    // The host makes a new context.
    world_.reset();
    world_ = std::make_unique<World>();
    ++lost_;
    create();
  }

  std::unique_ptr<World> world_;
  fuzz::Random random_{0};
  sideray_service* service_ = nullptr;
  std::vector<Ticket> tickets_;
  std::array<std::array<sideray_ticket, 3>, views> newest_{};  // by view and kind
  sideray_ticket last_ = 0;
  std::string log_;
};

TEST_F(Sequences, HoldWhatTheModelSays) {
  setenv("SIDERAY_TRANSPORT", "persistent", 1);
  uint64_t first = 1, count = 150;
  if (const char* wanted = std::getenv("SIDERAY_SEQUENCES")) {
    char* end = nullptr;
    first = std::strtoull(wanted, &end, 10);
    count = *end == ':' ? std::strtoull(end + 1, nullptr, 10) : 1;
  }
  expected_ = frame_of_new_service();
  ASSERT_FALSE(expected_.empty());
  for (uint64_t seed = first; seed < first + count && !HasFailure(); ++seed) run(seed);
  std::printf("%llu sequences, %llu calls, %llu refused, %llu frames, %llu contexts lost\n",
              static_cast<unsigned long long>(count), static_cast<unsigned long long>(calls_),
              static_cast<unsigned long long>(refused_), static_cast<unsigned long long>(frames_),
              static_cast<unsigned long long>(lost_));
  unsetenv("SIDERAY_TRANSPORT");
  if (count >= 150) {
    EXPECT_GT(refused_, 500u);
    EXPECT_GT(lost_, 10u);
  }
}

}  // namespace
}  // namespace sideray::tests::sequences_test
