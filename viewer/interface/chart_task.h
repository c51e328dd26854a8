// Runs `sideray chart` for the window's view in another process. Main thread.
#pragma once

#include <sys/types.h>

#include <optional>
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
  // Ends the process if it runs. Does not wait for one that cannot be ended.
  void stop();
  bool is_running() const { return child_ > 0; }

  struct News {
    std::string text;
    bool is_error = false;
  };
  // Returns what has happened since the last call: the process has ended, and its page is being opened, or no program
  // opens it.
  std::optional<News> poll();

 private:
  std::optional<News> poll_chart();
  std::optional<News> poll_opener();

  std::string program_, page_;
  pid_t child_ = 0;
  pid_t opener_ = 0;  // opens the page; may run as long as the browser
};

}  // namespace sideray::viewer
