// A bar on standard error while work goes on; nothing where that is no terminal. Main thread.
#pragma once

#include <cstddef>
#include <string>

namespace sideray::cli {

class Progress {
 public:
  explicit Progress(size_t steps);
  ~Progress();  // takes the bar away
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Shows what is done now; the step before is finished.
  void next(const std::string& what);

 private:
  size_t steps_, begun_ = 0;
  bool shown_;
};

}  // namespace sideray::cli
