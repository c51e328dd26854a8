#include "viewer/interface/chart_task.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "scenes/base/files.h"

namespace sideray::viewer {
namespace {

int spawn(pid_t& child, std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return ::posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
}

}  // namespace

void ChartTask::stop() {
  if (!is_running()) return;
  ::kill(child_, SIGTERM);
  ::waitpid(child_, nullptr, 0);
  child_ = 0;
}

void ChartTask::start(const std::vector<std::string>& words, const std::string& folder) {
  std::vector<std::string> command{program_, "chart"};
  command.insert(command.end(), words.begin(), words.end());
  command.insert(command.end(), {"-o", folder});
  folder_ = folder;
  if (const int error = spawn(child_, std::move(command)); error != 0) {
    child_ = 0;
    scenes::refuse("{}: cannot be started: {}; install sideray beside sideray-view", program_, std::strerror(error));
  }
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(child_), 10);  // the window has priority
}

std::string ChartTask::poll() {
  int status = 0;
  if (!is_running() || ::waitpid(child_, &status, WNOHANG) != child_) return "";
  child_ = 0;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fmt::format("chart: failed; what it says is in the terminal of this window");
  pid_t opener = 0;
  const std::string page = folder_ + "/index.html";
  if (spawn(opener, {"xdg-open", page}) == 0) ::waitpid(opener, nullptr, 0);
  return fmt::format("chart: {}", page);
}

}  // namespace sideray::viewer
