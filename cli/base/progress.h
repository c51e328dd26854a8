// Shows progress as a bar on standard error, and nothing where that is no terminal. Main thread.
#pragma once

#include <cstddef>
#include <string>

namespace sideray::cli {

class Progress {
 public:
  explicit Progress(size_t steps);
  ~Progress();  // removes the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Ends the step before and shows the next one.
  void next(const std::string& what);

 private:
  size_t steps_, begun_ = 0;
  bool shown_;
};

}  // namespace sideray::cli
