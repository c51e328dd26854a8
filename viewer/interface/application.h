// Runs `sideray view`: the window, its pictures and its input. Main thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "viewer/base/arguments.h"
#include "viewer/base/watchdog.h"
#include "viewer/interface/chart_task.h"
#include "viewer/interface/loader.h"
#include "viewer/interface/panel.h"
#include "viewer/interface/picture_area.h"

namespace sideray::viewer {

class Application {
 public:
  // `program` is the path of sideray, which draws charts. Throws Error where no window can be opened.
  Application(const Arguments& arguments, const std::string& program);
  // Runs until the window is closed. Ends the program with code 1 if its display or its OpenGL context is lost.
  void run();
  // Waits until drawing and loading end, which cannot be interrupted. Returns false after `seconds`.
  bool ends_within(double seconds);

 private:
  void start(const Arguments& arguments);
  void press(int key, bool with_control);
  void drop(const std::vector<std::string>& paths);
  SceneSource wanted_source() const;
  void take_variant();
  void take_scene();
  void take_chart();
  void take_first_view();
  void fly(double seconds);
  void play();
  void follow_camera();
  void update();
  void draw(const Drawer::Shown& shown);
  void grant(Wish wish, const Drawer::Shown& shown);
  void save_picture(const Drawer::Shown& shown);
  void watch();
  void loop();
  std::string way_back() const;
  [[noreturn]] void end_with(const std::string& cause);
  [[noreturn]] void end_without_display();
  [[noreturn]] void end_without_driver();
  double seconds_to_wait() const;
  bool flies(int key) const;
  bool is_flying() const;
  std::string title(const Drawer::Shown& shown) const;

  std::string way_back_ = "start it again";  // not changed while `watch_` is set
  ChartTask chart_;
  Watchdog watchdog_;
  std::optional<Watchdog::Watch> watch_;  // set while the main thread waits for the driver, also at the end
  Arguments arguments_;
  Window window_;
  Machine machine_;
  Loader loader_;
  State state_;
  PictureArea pictures_;
  Panel panel_;
  std::optional<Drawer> drawer_;
  double last_loop_ = 0, watched_at_ = 0, blinked_at_ = 0, played_at_ = 0;
  float width_ = 0, height_ = 0;  // of the pictures, in units of the window
  bool is_first_scene_ = true;
  int command_key_ = 0;  // pressed with Control, and still down; 0 = none
};

}  // namespace sideray::viewer
