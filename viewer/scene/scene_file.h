// A scene as its file has it, with its surroundings, ready to be drawn at any moment of its animation. Any thread, several at once.
#pragma once

#include <sideray/plan.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scenes/builtin/surroundings.h"
#include "scenes/content/content.h"

namespace sideray::viewer {

struct SceneSource {
  std::string scene;          // a .gltf or .glb file, or a built-in scene
  std::string animation;      // "" = the first
  std::string variant;        // of the materials; "" = none
  bool default_light = true;  // a sun for files without lights
  scenes::Surroundings surroundings;
};

class SceneFile {
 public:
  // Throws Error with one line that says what is wrong.
  explicit SceneFile(const SceneSource& source);

  const SceneSource& source() const { return source_; }
  // What is said of it never changes; where things are does, so that `content` is read for names and materials only.
  const scenes::Content& content() const { return content_; }
  bool moves() const { return scenes::moves(content_); }
  double length_s() const;  // of its longest animation; 0 = none
  double radius() const { return radius_; }  // half the diagonal of all that is in it

  // The camera `index` of the file at that time; one that frames everything where the file has none.
  sideray_camera camera(size_t index, double time_s, float aspect);
  sideray_camera framing(float aspect);

  // The scene at that time. `selected` is the option ray-traced, "" = auto; `camera` and size are what "largest:K" of it is
  // of. Throws Error where the selection does not fit.
  const Scene& at(double time_s, const std::string& selected, const sideray_camera& camera, uint32_t width, uint32_t height);
  // Whether the object was selected when the scene was last drawn.
  bool is_traced(size_t object);
  sideray_scene_facts facts();

  // Whether the file of the scene or of its surroundings is another one than was read, or than at the call before: each change
  // is told once. Main thread.
  bool has_changed();

 private:
  using Times = std::vector<std::filesystem::file_time_type>;
  Times file_times() const;
  void move_to(double time_s);

  SceneSource source_;
  Times seen_;
  std::mutex mutex_;
  scenes::Content content_;
  Scene scene_;
  double time_s_ = 0, radius_ = 1;
  std::string selection_ = "auto";
  std::vector<bool> traced_;
};

}  // namespace sideray::viewer
