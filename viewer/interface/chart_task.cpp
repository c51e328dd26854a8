#include "viewer/interface/chart_task.h"

#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

#include "scenes/base/files.h"

namespace sideray::viewer {
namespace {

constexpr std::chrono::milliseconds wait_time{5};
constexpr int most_waits = 100;

int spawn(pid_t& child, std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = ::posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
  if (error != 0) child = 0;
  return error;
}

// Returns whether a process succeeded once it has ended, and then sets its number to 0; empty while it runs or if the
// number is 0.
std::optional<bool> ended(pid_t& child) {
  int status = 0;
  if (child == 0 || ::waitpid(child, &status, WNOHANG) != child) return {};
  child = 0;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string opened_by_hand(const std::string& page) {
  return "chart: no browser was found; open " + page;
}

}  // namespace

void ChartTask::stop() {
  if (!is_running()) return;
  ::kill(child_, SIGTERM);
  for (int i = 0; i < most_waits && !ended(child_); ++i) std::this_thread::sleep_for(wait_time);
  if (is_running()) ::kill(child_, SIGKILL);
  child_ = 0;
}

void ChartTask::start(const std::vector<std::string>& words, const std::string& folder) {
  std::vector<std::string> command{program_, "chart"};
  command.insert(command.end(), words.begin(), words.end());
  command.insert(command.end(), {"-o", folder});
  page_ = folder + "/index.html";
  if (const int error = spawn(child_, std::move(command)); error != 0)
    scenes::refuse("{}: cannot be started: {}; install sideray beside sideray-view", program_, std::strerror(error));
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(child_), 10);  // the window has priority
}

std::optional<ChartTask::News> ChartTask::poll_chart() {
  const std::optional<bool> succeeded = ended(child_);
  if (!succeeded) return {};
  if (!*succeeded) return News{"chart: failed; the terminal of this window has the reason", true};
  if (spawn(opener_, {"xdg-open", page_}) != 0) return News{opened_by_hand(page_)};
  return News{"chart: opens " + page_};
}

std::optional<ChartTask::News> ChartTask::poll_opener() {
  const std::optional<bool> succeeded = ended(opener_);
  if (!succeeded || *succeeded) return {};
  return News{opened_by_hand(page_)};
}

std::optional<ChartTask::News> ChartTask::poll() {
  if (const std::optional<News> news = poll_chart()) return news;
  return poll_opener();
}

}  // namespace sideray::viewer
