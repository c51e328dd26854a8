// Runs `sideray chart` for the window's view in another process. Main thread.
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

  // Starts it with `words`: SCENE and options. Throws Error where the program cannot be started.
  void start(const std::vector<std::string>& words, const std::string& folder);
  // Ends the process if it runs.
  void stop();
  bool is_running() const { return child_ > 0; }
  // Once the process has ended, opens its page and returns a message; "" while it runs.
  std::string poll();

 private:
  std::string program_, folder_;
  pid_t child_ = 0;
};

}  // namespace sideray::viewer
