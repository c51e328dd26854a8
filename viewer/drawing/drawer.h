// Draws the window's pictures on two threads of its own: one draws whole pictures; the other draws smaller previews in
// time, while whole pictures take long. Unless stated, only the window's thread calls it, and calls never wait for a
// picture.
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
  // Cancels the pictures that are being drawn.
  ~Drawer();

  // Shows a view, and cancels a slow picture of another view. Call it every frame: a picture that has only begun cannot
  // be cancelled.
  void show(const View& view);
  // Cancels the pictures being drawn and begins none; is_idle() says when they have ended. Call it every frame.
  void stop();
  bool is_idle() const;

  struct Shown {
    std::array<std::shared_ptr<const Frame>, sides> frames;
    std::shared_ptr<const DifferenceMap> map;
    std::shared_ptr<const Inspection> inspection;
    std::array<std::string, sides> errors;  // why a side cannot be drawn; "" = it can
    std::string device;                     // "" until it is known
    float budget_ms = 0;                    // default for moving pictures; 0 = smaller pictures are drawn instead
    uint64_t pictures = 0;                  // drawn since the window was opened
  };
  Shown shown() const;

 private:
  struct Side {
    uint64_t number = 0;           // of the view that the other fields describe
    bool has_picture = false;      // a whole one
    bool has_preview = false;
    bool is_done = false;
    double spent_ms = 0;           // on whole pictures
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
  Painter whole_, small_;  // one for each thread
  uint64_t whole_of_ = 0;  // number of the view whose slow whole picture is being drawn; 0: none
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
