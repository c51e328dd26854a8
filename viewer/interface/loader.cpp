#include "viewer/interface/loader.h"

#include <chrono>

namespace sideray::viewer {

void Loader::load(const SceneSource& source) {
  next_ = source;
  if (!is_loading()) begin();
}

void Loader::begin() {
  source_ = *std::exchange(next_, std::nullopt);
  loading_ = std::async(std::launch::async, [source = source_, wake = wake_] {
    Loaded loaded;
    try {
      loaded.scene = std::make_shared<SceneFile>(source);
    } catch (const std::exception& failure) {
      loaded.error = failure.what();
    }
    wake();
    return loaded;
  });
}

std::optional<Loader::Loaded> Loader::take() {
  if (!is_loading() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
  Loaded loaded = loading_.get();
  if (!next_) return loaded;
  begin();
  return {};
}

}  // namespace sideray::viewer
