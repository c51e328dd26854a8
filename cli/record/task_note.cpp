#include "cli/record/task_note.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <thread>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

// Network file systems may report times that are up to a minute old.
constexpr std::chrono::seconds between_signs(5), longest_silence(90);

std::string note_path(const std::string& folder, uint32_t shard) {
  return (fs::path(shards_folder(folder)) / fmt::format("{:04}.json", shard)).string();
}

std::string host_name() {
  char host[256] = "";
  gethostname(host, sizeof(host) - 1);
  return host;
}

// Identifies the space of process ids: two machines may have the same name, and containers have ids of their own.
std::string process_space() {
  std::error_code ignored;
  return host_name() + " " + fs::read_symlink("/proc/self/ns/pid", ignored).string();
}

std::string now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

bool is_alive(const Json& note, const std::string& path) {
  if (note.value("space", "") == process_space() && kill(note.value("pid", 0), 0) != 0 && errno == ESRCH) return false;
  std::error_code error;
  const auto age = fs::file_time_type::clock::now() - fs::last_write_time(path, error);
  return !error && age < longest_silence;
}

// Touches a file every few seconds until it is destroyed.
class SignsOfLife {
 public:
  explicit SignsOfLife(const std::string& path)
      : thread_([this, path](const std::stop_token& stop) {
          std::unique_lock lock(mutex_);
          while (!stop.stop_requested()) {
            wake_.wait_for(lock, stop, between_signs, [] { return false; });
            utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
          }
        }) {}

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;  // ends before the other members are destroyed
};

}  // namespace

std::string node_name() {
  for (const char* name : {"SLURMD_NODENAME", "NODE_NAME"})
    if (const char* node = std::getenv(name); node && *node) return node;
  return host_name();
}

int run_task(const RunRecord& run, Shard shard, const std::function<int()>& work) {
  const std::string path = note_path(run.folder, shard.index);
  Json note = {{"schema", 1},     {"state", "running"},       {"node", node_name()},
               {"pid", getpid()}, {"space", process_space()}, {"program", program_build()},
               {"began", now()}};
  const auto end = [&](const char* state, const std::string& error) {
    note["state"] = state;
    note["ended"] = now();
    if (!error.empty()) note["error"] = error;
    write_text(path, scenes::json_text(note, 1) + "\n");
  };
  write_text(path, scenes::json_text(note, 1) + "\n");
  try {
    const int code = [&] {
      const SignsOfLife signs(path);
      return work();
    }();
    end(code == exit_ok ? "done" : "failed", "");
    return code;
  } catch (const std::exception& error) {
    try {
      end("failed", error.what());
    } catch (const Error&) {
      // The folder cannot be written any more; the task will count as lost.
    }
    throw;
  }
}

std::optional<TaskNote> read_task(const std::string& folder, uint32_t shard) {
  constexpr uint64_t most_bytes = 1 << 20;
  const std::string path = note_path(folder, shard);
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  const Json note = Json::parse(scenes::read_file(path, most_bytes), nullptr, false);
  if (!note.is_object()) return {};
  TaskNote task{note.value("state", ""), note.value("node", ""), note.value("error", "")};
  if (task.state == "running" && !is_alive(note, path)) task.state = "lost";
  return task;
}

}  // namespace sideray::cli
