// Draws what the window wants to see, on threads of its own: one draws whole pictures, and one, while these take long, smaller
// ones in time. Other than stated, its calls are the window's thread's and never wait for a picture.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "viewer/drawing/painter.h"

namespace sideray::viewer {

class Drawer {
 public:
  // `wake` is called on any thread when there is something new.
  Drawer(Machine& machine, std::function<void()> wake);
  // Ends the pictures that are being drawn.
  ~Drawer();

  // Ends a picture of another view that takes long. Is called again and again, since a picture that only begins does not end.
  void show(const View& view);
  // Ends the pictures that are being drawn, and begins none; is_idle() then says when they have ended. Likewise.
  void stop();
  bool is_idle() const;

  struct Shown {
    std::array<std::shared_ptr<const Frame>, sides> frames;
    std::shared_ptr<const DifferenceMap> map;
    std::shared_ptr<const Inspection> inspection;
    std::array<std::string, sides> errors;  // why a side cannot be drawn; "" = it can
    std::string device;                     // "" until it is known
    float budget_ms = 0;                    // of moving pictures, where nothing else is set; 0 = smaller ones are drawn
    uint64_t pictures = 0;                  // that were drawn since the window was opened
  };
  Shown shown() const;

 private:
  struct Side {
    uint64_t number = 0;           // of the view that the rest is about
    bool has_picture = false;      // a whole one
    bool has_preview = false;
    bool is_done = false;
    double spent_ms = 0;           // in whole pictures
  };

  void draw_pictures();
  void draw_previews();
  Side& side_of(size_t index);
  std::optional<size_t> next_side();
  std::optional<size_t> next_preview();
  bool inspects() const;
  bool keeps_budget(const View& view, Way way) const;
  bool is_slow(Way way) const;
  void learn(const View& view, Way way, const Frame& frame);
  Effort preview_effort(Way way);
  void paint(std::unique_lock<std::mutex>& lock, Painter& painter, size_t side, const Effort& effort);
  void publish(size_t side, std::shared_ptr<const Frame> frame);
  bool compare(std::unique_lock<std::mutex>& lock);
  void inspect(std::unique_lock<std::mutex>& lock);

  Machine& machine_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stops_ = false;
  size_t busy_ = 0;  // threads that draw
  Painter whole_, small_;  // of either thread
  uint64_t whole_of_ = 0;  // the view of which a whole picture is being drawn that takes long; 0: none
  View view_;
  std::array<Side, sides> sides_;
  Shown shown_;
  struct Speed {
    // For whole pictures at rest, for whole pictures that move within a budget, and for previews; 0: not known yet.
    double ns_per_pixel = 0, moving_ns_per_pixel = 0, preview_ns_per_pixel = 0;
    uint32_t preview_step = 0;  // each side of a preview is this many times shorter
  };
  std::array<Speed, way_count> speeds_;
  struct Inspected {
    std::weak_ptr<SceneFile> scene;
    double time_s = 0;
    std::optional<Tracer> tracer;
  };
  Inspected inspected_;
  std::thread pictures_, previews_;
};

}  // namespace sideray::viewer
