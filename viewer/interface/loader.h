// Reads scenes beside the window. Main thread.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "viewer/scene/scene_file.h"

namespace sideray::viewer {

class Loader {
 public:
  // Called on a thread of its own when a scene is there, or is not.
  explicit Loader(std::function<void()> wake) : wake_(std::move(wake)) {}

  // A scene that is still being read is read to its end, and then left.
  void load(const SceneSource& source);
  bool is_loading() const { return loading_.valid(); }
  // What was asked for last.
  const SceneSource& latest() const { return next_ ? *next_ : source_; }

  struct Loaded {
    std::shared_ptr<SceneFile> scene;  // null: see error
    std::string error;
  };
  // What was read since the last call.
  std::optional<Loaded> take();

 private:
  void begin();

  std::function<void()> wake_;
  SceneSource source_;
  std::optional<SceneSource> next_;
  std::future<Loaded> loading_;
};

}  // namespace sideray::viewer
