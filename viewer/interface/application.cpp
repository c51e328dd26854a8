#include "viewer/interface/application.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>

#include "scenes/base/files.h"
#include "scenes/images/images.h"
#include "viewer/interface/command_line.h"

namespace sideray::viewer {
namespace {

constexpr double rest_s = 0.15;    // a camera that has not moved for this time rests
constexpr double watch_s = 1.0;    // between checks of the files
constexpr double blink_s = 0.5;
constexpr double tick_s = 1.0 / 60;
constexpr std::chrono::milliseconds most_time_of_driver{30'000};  // for one frame of the window, and for its end
constexpr float least_picture_width = 64;  // narrower windows have no panel

SceneSource source_of(const Arguments& arguments) {
  SceneSource source;
  source.scene = arguments.scene;
  source.animation = arguments.text("animation");
  source.variant = arguments.text("variant");
  source.default_light = arguments.text("default-light", "on") == "on";
  source.surroundings = {arguments.text("env", "sky"), static_cast<float>(arguments.number("env-scale", 1)),
                         static_cast<float>(arguments.number("env-rotate", 0))};
  return source;
}

std::array<uint32_t, 2> window_size(const Arguments& arguments) {
  const std::array<uint32_t, 2> picture = size_of(arguments.text("size", "1280x720"));
  return {picture[0] + static_cast<uint32_t>(panel_width), picture[1]};
}

bool is_environment(const std::string& path) {
  return path.ends_with(".hdr") || path.ends_with(".exr");
}

// Returns NAME-001.png, or the first such name that is free.
std::string free_name(const std::string& scene) {
  const std::string stem = std::filesystem::path(scene.substr(0, scene.find('?'))).stem().string();
  for (int number = 1;; ++number)
    if (const std::string name = fmt::format("{}-{:03}.png", stem, number); !std::filesystem::exists(name)) return name;
}

}  // namespace

Application::Application(const Arguments& arguments, const std::string& program)
    : chart_(program),
      watchdog_(most_time_of_driver, [this] { end_without_driver(); }),
      watch_(std::in_place, watchdog_),
      arguments_(arguments),
      window_(window_size(arguments)[0], window_size(arguments)[1],
              {[this](int key, bool with_control) { press(key, with_control); },
               [this](const std::vector<std::string>& paths) { drop(paths); }, [this] { end_without_display(); }}),
      machine_(arguments),
      loader_(Window::wake) {
  start(arguments);
  drawer_.emplace(machine_, Window::wake);
  watch_.reset();
}

void Application::start(const Arguments& arguments) {
  for (const auto& [name, value] : arguments.given)
    if (sideray_option_find(name.c_str()) && !is_decided_by_window(name)) state_.view.options.set(name, value);
  state_.view.display.exposure_ev = static_cast<float>(arguments.number("exposure", 0));
  state_.view.display.tonemap = scenes::tonemap_named(arguments.text("tonemap", "pbr-neutral"));
  state_.view.time_s = arguments.number("time", 0);
  loader_.load(source_of(arguments));
}

void Application::drop(const std::vector<std::string>& paths) {
  SceneSource source = wanted_source();
  for (const std::string& path : paths) {
    if (is_environment(path))
      source.surroundings.name = path;
    else
      source.scene = path, source.animation.clear(), source.variant.clear();
  }
  loader_.load(source);
}

// Returns the scene that is shown, or that is being loaded.
SceneSource Application::wanted_source() const {
  if (loader_.is_loading()) return loader_.latest();
  return state_.view.scene ? state_.view.scene->source() : source_of(arguments_);
}

void Application::take_variant() {
  if (!state_.wanted_variant) return;
  SceneSource source = wanted_source();
  source.variant = *std::exchange(state_.wanted_variant, std::nullopt);
  loader_.load(source);
}

// Shows a scene that was loaded. If it cannot be read the shown scene stays.
void Application::take_scene() {
  const std::optional<Loader::Loaded> loaded = loader_.take();
  if (!loaded) return;
  if (!loaded->scene) return state_.complain(loaded->error);
  const bool is_other = !state_.view.scene || state_.view.scene->source().scene != loaded->scene->source().scene;
  state_.view.scene = loaded->scene;
  state_.facts = loaded->scene->facts();
  state_.message.clear();
  const auto& warnings = loaded->scene->content().warnings;
  if (warnings.begin() != warnings.end()) state_.say(*warnings.begin());
  if (is_other) {
    state_.navigation.follow(loaded->scene->content().cameras.empty() ? std::nullopt : std::optional<size_t>(0));
    if (is_first_scene_)
      take_first_view();
    else
      state_.view.time_s = 0;
  }
  is_first_scene_ = false;
  state_.touch();
}

void Application::take_chart() {
  const std::optional<ChartTask::News> news = chart_.poll();
  if (!news) return;
  if (news->is_error)
    state_.complain(news->text);
  else
    state_.say(news->text);
}

// Shows the first view that the command line names.
void Application::take_first_view() {
  const std::string eye = arguments_.text("eye"), camera = arguments_.text("camera");
  if (!eye.empty()) {
    const std::array<double, 3> from = point_of("eye", eye), to = point_of("target", arguments_.text("target"));
    state_.navigation.look({from[0], from[1], from[2]}, {to[0], to[1], to[2]}, arguments_.number("fov", 45));
  } else if (!camera.empty()) {
    const auto& cameras = state_.view.scene->content().cameras;
    const auto at =
        std::find_if(cameras.begin(), cameras.end(), [&](const scenes::Camera& c) { return c.name == camera; });
    state_.navigation.follow(at != cameras.end() ? static_cast<size_t>(at - cameras.begin())
                                                 : static_cast<size_t>(arguments_.number("camera", 0)));
  }
}

void Application::press(int key, bool with_control) {
  if (with_control) {
    command_key_ = key;
    if (key == GLFW_KEY_Q) window_.close();
    if (key == GLFW_KEY_S) grant(Wish::save_picture, drawer_->shown());
    if (key == GLFW_KEY_C) grant(Wish::copy_command, drawer_->shown());
    if (key == GLFW_KEY_R) grant(Wish::reload, drawer_->shown());
    return;
  }
  constexpr Comparison next[] = {Comparison::slider, Comparison::only_b, Comparison::map, Comparison::only_a};
  switch (key) {
    case GLFW_KEY_TAB: state_.has_panel = !state_.has_panel; break;
    case GLFW_KEY_C: state_.comparison = next[static_cast<size_t>(state_.comparison)]; break;
    case GLFW_KEY_M: state_.comparison = state_.comparison == Comparison::map ? Comparison::only_a : Comparison::map; break;
    case GLFW_KEY_B: state_.blinks = !state_.blinks; break;
    case GLFW_KEY_I: state_.inspects = !state_.inspects; break;
    case GLFW_KEY_SPACE: state_.plays = !state_.plays && state_.view.scene && state_.view.scene->moves(); break;
    case GLFW_KEY_F: state_.navigation.follow(std::nullopt), state_.touch(); break;
    default: break;
  }
}

// Returns whether a key moves the camera. A key of a command, such as Ctrl+S, does not, even after Control is released.
bool Application::flies(int key) const {
  return key != command_key_ && window_.is_down(key);
}

bool Application::is_flying() const {
  if (ImGui::GetIO().WantTextInput || !state_.view.scene) return false;
  if (window_.is_down(GLFW_KEY_LEFT_CONTROL) || window_.is_down(GLFW_KEY_RIGHT_CONTROL)) return false;
  constexpr int keys[] = {GLFW_KEY_W, GLFW_KEY_A, GLFW_KEY_S, GLFW_KEY_D, GLFW_KEY_Q, GLFW_KEY_E};
  return std::any_of(std::begin(keys), std::end(keys), [&](int key) { return flies(key); });
}

void Application::fly(double seconds) {
  if (!is_flying()) return;
  const auto along = [&](int forward, int back) {
    return static_cast<double>(flies(forward)) - static_cast<double>(flies(back));
  };
  const glm::dvec3 direction(along(GLFW_KEY_D, GLFW_KEY_A), along(GLFW_KEY_E, GLFW_KEY_Q), along(GLFW_KEY_W, GLFW_KEY_S));
  // The speed covers 0.7 of the distance to the surface in the middle each second, within bounds by the scene's size.
  const double radius = state_.view.scene->radius();
  const double depth = depth_at(drawer_->shown().frames[0].get(), 0.5, 0.5, radius);
  const double speed = std::clamp(0.7 * depth, 0.002 * radius, 0.2 * radius) * (window_.is_down(GLFW_KEY_LEFT_SHIFT) ? 4.0 : 1.0);
  state_.navigation.move(direction * speed * std::min(seconds, 0.1));
  state_.moved_at = glfwGetTime();
}

// Advances the animation once the picture of the last time is shown.
void Application::play() {
  const double now = glfwGetTime();
  if (state_.plays && state_.view.scene) {
    const auto frame = drawer_->shown().frames[0];
    if (frame && frame->number == state_.view.number) {
      state_.view.time_s += std::min(now - played_at_, 0.5);
      played_at_ = now;
      state_.touch();
    }
    state_.moved_at = now;
  } else {
    played_at_ = now;
  }
}

void Application::follow_camera() {
  const float aspect = static_cast<float>(state_.view.width) / static_cast<float>(std::max(state_.view.height, 1u));
  const auto index = state_.navigation.file_camera();
  SceneFile& scene = *state_.view.scene;
  const sideray_camera of_file = index ? scene.camera(*index, state_.view.time_s, aspect) : scene.framing(aspect);
  const double distance = depth_at(drawer_->shown().frames[0].get(), 0.5, 0.5, scene.radius());
  const sideray_camera camera = state_.navigation.camera(of_file, distance);
  const auto same = [](const sideray_camera& a, const sideray_camera& b) {
    return std::equal(std::begin(a.world_from_camera), std::end(a.world_from_camera), std::begin(b.world_from_camera)) &&
           a.yfov == b.yfov && a.z_near == b.z_near && a.orthographic == b.orthographic && a.half_height == b.half_height;
  };
  if (same(camera, state_.view.camera)) return;
  state_.view.camera = camera;
  state_.touch();
}

void Application::update() {
  if (command_key_ > 0 && !window_.is_down(command_key_)) command_key_ = 0;
  take_variant();
  take_scene();
  take_chart();
  const double now = glfwGetTime();
  fly(now - last_loop_);
  last_loop_ = now;
  play();
  if (state_.blinks && now - blinked_at_ >= blink_s) state_.shows_b = !state_.shows_b, blinked_at_ = now;
  const float scale = window_.pixels_per_unit();
  const auto width = static_cast<uint32_t>(std::max(width_ * scale, 0.0f));
  const auto height = static_cast<uint32_t>(std::max(height_ * scale, 0.0f));
  if (width != state_.view.width || height != state_.view.height) {
    state_.view.width = width, state_.view.height = height;
    state_.touch();
  }
  state_.view.shown_sides = state_.comparison == Comparison::only_a && !state_.blinks ? 1 : sides;
  state_.view.wants_map = state_.comparison == Comparison::map;
  state_.view.is_moving = state_.moved_at >= 0 && now - state_.moved_at < rest_s;
  state_.view.inspects = state_.inspects;
  if (!state_.inspects) state_.view.inspected.reset();
  if (state_.view.scene) follow_camera();
  drawer_->show(state_.view);
}

void Application::draw(const Drawer::Shown& shown) {
  Wish wish = Wish::nothing;
  way_back_ = way_back();
  watch_.emplace(watchdog_);
  window_.draw([&] {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const bool has_panel = state_.has_panel && size.x > panel_width + least_picture_width;
    state_.is_panel_seen = has_panel;
    width_ = size.x - (has_panel ? panel_width : 0), height_ = size.y;
    pictures_.draw(state_, shown, {width_, height_});
    if (has_panel) wish = panel_.draw(state_, shown, {width_, height_}, {loader_.is_loading(), chart_.is_running()});
  });
  watch_.reset();
  grant(wish, shown);
}

void Application::save_picture(const Drawer::Shown& shown) {
  const size_t side = state_.comparison == Comparison::only_b || (state_.blinks && state_.shows_b) ? 1 : 0;
  const auto& frame = shown.frames[side];
  if (!frame) return;
  const std::string name = free_name(state_.view.scene->source().scene);
  if (state_.comparison == Comparison::map && shown.map)
    scenes::write_png(name, shown.map->width, shown.map->height, shown.map->rgb);
  else
    scenes::write_png(name, frame->width, frame->height, frame->rgb);
  state_.say(fmt::format("saved {}, {}x{}, {} positions", name, frame->width, frame->height, frame->positions));
}

void Application::grant(Wish wish, const Drawer::Shown& shown) {
  if (wish == Wish::nothing || !state_.view.scene) return;
  try {
    std::vector<std::string> words = words_of(state_.view, state_.view.ways[0], state_.navigation, arguments_);
    if (wish == Wish::save_picture) return save_picture(shown);
    if (wish == Wish::reload) return loader_.load(state_.view.scene->source());
    if (wish == Wish::chart) {
      const std::string folder = std::filesystem::path(free_name(state_.view.scene->source().scene)).stem().string() + "-chart";
      chart_.start(words, folder);
      return state_.say("charting into " + folder + "; its page opens when it is done");
    }
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--exposure", fmt::format("{}", state_.view.display.exposure_ev), "--tonemap",
                               scenes::tonemap_names[static_cast<size_t>(state_.view.display.tonemap)],
                               "--samples", fmt::format("{}", still_positions), "-o", "picture.png"});
    const std::string line = line_of(words);
    window_.copy_text(line);
    state_.say("copied: " + line);
  } catch (const std::exception& error) {
    state_.complain(error.what());
  }
}

void Application::watch() {
  const double now = glfwGetTime();
  if (now - watched_at_ < watch_s || loader_.is_loading() || !state_.view.scene) return;
  watched_at_ = now;
  if (state_.view.scene->has_changed()) loader_.load(state_.view.scene->source());
}

double Application::seconds_to_wait() const {
  if (is_flying()) return tick_s;
  if (state_.view.is_moving) return rest_s;
  if (state_.blinks) return blink_s;
  return watch_s;
}

std::string Application::title(const Drawer::Shown& shown) const {
  if (!state_.view.scene) return loader_.is_loading() ? "loading - Sideray" : "no scene - Sideray";
  std::string title = state_.view.scene->source().scene;
  for (size_t i = 0; i < state_.view.shown_sides; ++i) {
    const auto& frame = shown.frames[i];
    const bool is_current = frame && frame->number == state_.view.number && !frame->is_preview;
    title += fmt::format(" - {} {}/{}", name_of(state_.view.ways[i]), is_current ? frame->positions : 0,
                         positions_of(state_.view.ways[i]));
  }
  if (const auto& frame = shown.frames[0])
    title += fmt::format(" - picture {}: {}x{}, {:.1f} ms", shown.pictures, frame->width, frame->height, frame->ms);
  return title + " - Sideray";
}

// Returns the command that shows the current view again, for messages.
std::string Application::way_back() const {
  if (!state_.view.scene) return "start it again";
  std::vector<std::string> words = words_of(state_.view, Way::chosen, state_.navigation, arguments_);
  words.insert(words.begin(), "view");
  return "go on with: " + line_of(words);
}

// Ends the program at once, with code 1 and one line. Threads and contexts are left to the system: what they wait for
// may never come.
void Application::end_with(const std::string& cause) {
  fmt::print(stderr, "sideray: {}; {}\n", cause, way_back_);
  chart_.stop();
  std::_Exit(EXIT_FAILURE);
}

// Xlib does not return to the program after its display is gone.
void Application::end_without_display() {
  if (!watch_) way_back_ = way_back();
  end_with("window: its display is gone");
}

// Called by the watchdog, while the main thread waits for the driver.
void Application::end_without_driver() {
  end_with(fmt::format("window: its display or OpenGL has not answered for {} s", most_time_of_driver.count() / 1000));
}

void Application::run() {
  try {
    loop();
  } catch (const std::exception& failure) {
    if (!watch_) way_back_ = way_back();
    end_with(failure.what());
  }
  watch_.emplace(watchdog_);
  window_.hide();
}

void Application::loop() {
  int frames_to_draw = 3;  // Dear ImGui needs a few frames to react
  while (!window_.is_closing()) {
    if (window_.wait(frames_to_draw > 1 ? 0 : seconds_to_wait())) frames_to_draw = 3;
    const uint64_t before = state_.view.number;
    const bool was_b = state_.shows_b;
    update();
    watch();
    const Drawer::Shown shown = drawer_->shown();
    window_.set_title(title(shown));
    if (state_.view.number != before || state_.shows_b != was_b) frames_to_draw = std::max(frames_to_draw, 1);
    if (frames_to_draw <= 0) continue;
    draw(shown);
    --frames_to_draw;
  }
}

bool Application::ends_within(double seconds) {
  for (const double start = glfwGetTime(); glfwGetTime() - start < seconds;
       std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    drawer_->stop();
    if (drawer_->is_idle() && !loader_.is_loading()) return true;
  }
  chart_.stop();
  return false;
}

}  // namespace sideray::viewer
