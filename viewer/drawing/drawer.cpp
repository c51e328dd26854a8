#include "viewer/drawing/drawer.h"

#include <algorithm>
#include <cmath>

#include "lab/metrics/flip.h"
#include "viewer/drawing/inspect.h"
#include "viewer/drawing/modes.h"

namespace sideray::viewer {
namespace {

constexpr double ns_per_ms = 1e6;
constexpr double frame_ms = 90;          // of what moves without a GPU: ten pictures a second
constexpr double slow_ms = 60;           // whole pictures that take longer have previews
constexpr float hardware_budget_ms = 16;
constexpr uint32_t first_step = 8;       // of the first preview, when nothing is known

double pixels_of(const View& view) {
  return static_cast<double>(view.width) * view.height;
}

Effort smaller(const View& view, uint32_t step, float budget_ms) {
  return {std::max(1u, (view.width + step - 1) / step), std::max(1u, (view.height + step - 1) / step), true, true, budget_ms};
}

bool is_power_of_two(uint64_t n) {
  return (n & (n - 1)) == 0;
}

}  // namespace

Drawer::Drawer(Machine& machine, std::function<void()> wake)
    : machine_(machine),
      wake_(std::move(wake)),
      whole_(machine),
      small_(machine),
      pictures_([this] { draw_pictures(); }),
      previews_([this] { draw_previews(); }) {}

Drawer::~Drawer() {
  stop();
  pictures_.join();
  previews_.join();
}

void Drawer::stop() {
  const std::lock_guard lock(mutex_);
  stops_ = true;
  whole_.cancel();
  small_.cancel();
  changed_.notify_all();
}

bool Drawer::is_idle() const {
  const std::lock_guard lock(mutex_);
  return busy_ == 0;
}

void Drawer::show(const View& view) {
  const std::lock_guard lock(mutex_);
  view_ = view;
  if (whole_of_ != 0 && whole_of_ != view.number) whole_.cancel();
  changed_.notify_all();
}

Drawer::Shown Drawer::shown() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}

Drawer::Side& Drawer::side_of(size_t index) {
  Side& side = sides_[index];
  if (side.number != view_.number) side = {view_.number};
  return side;
}

// Returns whether the view is drawn whole within a budget: on a GPU moving views are, however slow they are at rest.
bool Drawer::keeps_budget(const View& view, Way way) const {
  return view.is_moving && shown_.budget_ms > 0 && way != Way::reference;
}

bool Drawer::is_slow(Way way) const {
  const Speed& speed = speeds_[static_cast<size_t>(way)];
  const bool keeps = keeps_budget(view_, way);
  const double known = keeps ? speed.moving_ns_per_pixel : speed.ns_per_pixel;
  return known == 0 ? !keeps : known * pixels_of(view_) > slow_ms * ns_per_ms;
}

void Drawer::learn(const View& view, Way way, const Frame& frame) {
  Speed& speed = speeds_[static_cast<size_t>(way)];
  const bool keeps = keeps_budget(view, way);
  // Forgets the speed of motion: a motion may have been slow only because it uploaded everything.
  if (!frame.is_preview && !keeps) speed.moving_ns_per_pixel = 0;
  double& known = frame.is_preview ? speed.preview_ns_per_pixel
                  : keeps          ? speed.moving_ns_per_pixel
                                   : speed.ns_per_pixel;
  const double found = frame.ms * ns_per_ms / (static_cast<double>(frame.width) * frame.height);
  known = known == 0 ? found : 0.7 * known + 0.3 * found;
}

// Returns the unfinished side that has had the least time, so that a slow reference does not hold up the side that is
// compared with it.
std::optional<size_t> Drawer::next_side() {
  if (!view_.scene || view_.width == 0 || view_.height == 0) return {};
  std::optional<size_t> next;
  for (size_t i = 0; i < view_.shown_sides; ++i) {
    const Side& side = side_of(i);
    if (side.is_done || (view_.is_moving && is_slow(view_.ways[i]))) continue;
    // A picture comes when it is known how long it takes.
    if (is_slow(view_.ways[i]) && !side.has_preview && !side.has_picture) continue;
    if (!next || side.spent_ms < sides_[*next].spent_ms) next = i;
  }
  return next;
}

std::optional<size_t> Drawer::next_preview() {
  if (!view_.scene || view_.width == 0 || view_.height == 0) return {};
  for (size_t i = 0; i < view_.shown_sides; ++i) {
    const Side& side = side_of(i);
    if (is_slow(view_.ways[i]) && !side.has_preview && !side.has_picture && !side.is_done) return i;
  }
  return {};
}

bool Drawer::inspects() const {
  if (!view_.scene || !view_.inspected || view_.is_moving) return false;
  return !shown_.inspection || shown_.inspection->number != view_.number || shown_.inspection->pixel != *view_.inspected;
}

// Changes the step only if the time is far from the goal, because only pictures of one size share a history.
Effort Drawer::preview_effort(Way way) {
  Speed& speed = speeds_[static_cast<size_t>(way)];
  if (speed.preview_ns_per_pixel == 0) return smaller(view_, first_step, shown_.budget_ms);
  const auto ms = [&](uint32_t step) {
    return speed.preview_ns_per_pixel * pixels_of(view_) / (static_cast<double>(step) * step) / ns_per_ms;
  };
  uint32_t& step = speed.preview_step;
  if (step == 0 || ms(step) > 1.25 * frame_ms || (step > 1 && ms(step - 1) < 0.8 * frame_ms)) {
    step = 1;
    while (step < 64 && ms(step) > frame_ms) ++step;
  }
  return smaller(view_, step, shown_.budget_ms);
}

void Drawer::publish(size_t side_index, std::shared_ptr<const Frame> frame) {
  if (frame->number == view_.number) {
    Side& side = side_of(side_index);
    if (frame->is_preview && side.has_picture) return;
    (frame->is_preview ? side.has_preview : side.has_picture) = true;
    side.spent_ms += frame->is_preview ? 0 : frame->ms;
    side.is_done = frame->is_done;
  } else if (shown_.frames[side_index] && shown_.frames[side_index]->number > frame->number) {
    return;
  }
  shown_.errors[side_index].clear();
  shown_.frames[side_index] = std::move(frame);
  ++shown_.pictures;
  wake_();
}

void Drawer::paint(std::unique_lock<std::mutex>& lock, Painter& painter, size_t side, const Effort& effort) {
  const View view = view_;
  const Way way = view.ways[side];
  ++busy_;
  if (!effort.is_preview && is_slow(way)) whole_of_ = view.number;
  lock.unlock();
  std::shared_ptr<Frame> frame;
  std::string error;
  bool is_cancelled = false;
  try {
    frame = painter.paint(view, way, effort);
  } catch (const Error& failure) {
    is_cancelled = failure.status == SIDERAY_CANCELLED;
    error = failure.what();
  } catch (const std::exception& failure) {
    error = failure.what();
  }
  lock.lock();
  --busy_;
  if (!effort.is_preview) whole_of_ = 0;
  if (is_cancelled) return;
  if (!frame) {
    if (view.number != view_.number) return;
    side_of(side).is_done = true;
    shown_.errors[side] = error;
    shown_.frames[side] = nullptr;
    return wake_();
  }
  learn(view, way, *frame);
  publish(side, std::move(frame));
}

void Drawer::draw_pictures() {
  {
    std::string device;
    float budget_ms = 0;
    try {
      device = machine_.description();
      budget_ms = machine_.is_software() ? 0 : hardware_budget_ms;
    } catch (const std::exception& failure) {
      device = failure.what();
    }
    const std::lock_guard lock(mutex_);
    shown_.device = device;
    shown_.budget_ms = budget_ms;
  }
  wake_();
  std::unique_lock lock(mutex_);
  while (!stops_) {
    if (compare(lock)) continue;
    if (const std::optional<size_t> side = next_side())
      paint(lock, whole_, *side, {view_.width, view_.height, false, false, view_.is_moving ? shown_.budget_ms : 0});
    else
      changed_.wait(lock);
  }
}

void Drawer::draw_previews() {
  std::unique_lock lock(mutex_);
  while (!stops_) {
    if (const std::optional<size_t> side = next_preview()) {
      paint(lock, small_, *side, preview_effort(view_.ways[*side]));
      changed_.notify_all();
    } else if (inspects()) {
      inspect(lock);
    } else {
      changed_.wait(lock);
    }
  }
}

// Makes a map of differences at once, and then after 1, 2, 4, ... positions, because a map takes about as long as a
// picture. Returns whether there is a new map.
bool Drawer::compare(std::unique_lock<std::mutex>& lock) {
  const auto a = shown_.frames[0], b = shown_.frames[1];
  if (!view_.wants_map || view_.shown_sides < 2 || !a || !b || a->number != view_.number || b->number != view_.number) return false;
  if (a->is_preview || b->is_preview || a->display.empty() || b->display.size() != a->display.size()) return false;
  const auto is_due = [](const Frame& frame) { return frame.is_done || is_power_of_two(frame.positions); };
  const bool has_map = shown_.map && shown_.map->number == a->number;
  const bool is_known = has_map && shown_.map->positions == std::array{a->positions, b->positions};
  if (is_known || (has_map && !is_due(*a) && !is_due(*b))) return false;
  ++busy_;
  lock.unlock();
  auto map = std::make_shared<DifferenceMap>();
  const lab::FlipMap flip = lab::ldr_flip(a->display, b->display, a->width, a->height);
  *map = {a->number, {a->positions, b->positions}, a->width, a->height, lab::false_colours(flip.error), flip.mean};
  lock.lock();
  --busy_;
  shown_.map = std::move(map);
  wake_();
  return true;
}

void Drawer::inspect(std::unique_lock<std::mutex>& lock) {
  const View view = view_;
  const Pixel pixel = *view.inspected;
  ++busy_;
  lock.unlock();
  std::shared_ptr<Inspection> found;
  try {
    if (inspected_.scene.lock() != view.scene || inspected_.time_s != view.time_s || !inspected_.tracer) {
      inspected_.tracer.reset();
      const Scene& scene = view.scene->at(view.time_s, view.options["ray-traced"], view.camera, view.width, view.height);
      inspected_.tracer = machine_.tracer(scene);
      inspected_.scene = view.scene;
      inspected_.time_s = view.time_s;
    }
    found = std::make_shared<Inspection>(viewer::inspect(*inspected_.tracer, view, pixel));
  } catch (const std::exception& failure) {
    found = std::make_shared<Inspection>(Inspection{view.number, pixel, {{0, 0, 0, failure.what(), "", ""}}});
  }
  lock.lock();
  --busy_;
  shown_.inspection = std::move(found);
  wake_();
}

}  // namespace sideray::viewer
