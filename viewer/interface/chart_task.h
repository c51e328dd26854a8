// `sideray chart` of what the window shows, as a process beside it. Main thread.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace sideray::viewer {

class ChartTask {
 public:
  explicit ChartTask(std::string program) : program_(std::move(program)) {}
  ~ChartTask() { stop(); }
  ChartTask(const ChartTask&) = delete;
  ChartTask& operator=(const ChartTask&) = delete;

  // `words`: SCENE and options. Throws Error where the program cannot be started.
  void start(const std::vector<std::string>& words, const std::string& folder);
  // Ends it where it runs.
  void stop();
  bool is_running() const { return child_ > 0; }
  // What there is to say once it has ended, and opens its page; "" while it runs.
  std::string poll();

 private:
  std::string program_, folder_;
  pid_t child_ = 0;
};

}  // namespace sideray::viewer
