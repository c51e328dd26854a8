// Knows for how many frames in a row nothing has changed that the layers of a view depend on: then they are what they were.
// Inputs are compared, not announced; pictures by their hashes. One object a sequence; one thread calls it, and it works on
// the executor's.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/layers/layer_request.h"

namespace sideray::rt {

class StillView {
 public:
  // Learns of the next frame, and returns how many before it had the same inputs. Wind and sprites never stand still; a
  // frame that stands for the last one once more is none: it is drawn for its times.
  // `committed`: the snapshot as the host committed it.
  uint32_t learn(const CacheRequest& request, std::shared_ptr<const model::Snapshot> committed, Executor& executor);

 private:
  using PictureHash = std::array<uint64_t, 2>;
  bool is_last(const CacheRequest& request, const model::Snapshot& committed, const PictureHash& picture) const;

  CacheRequest request_;  // of the last frame; pointers in it are not followed
  std::shared_ptr<const model::Snapshot> committed_;
  PictureHash picture_{};
  uint32_t frames_ = 0;
};

}  // namespace sideray::rt
