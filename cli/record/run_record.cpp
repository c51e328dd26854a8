#include "cli/record/run_record.h"

#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t most_record_bytes = uint64_t{256} << 20;

std::string record_path(const std::string& folder) {
  return (fs::path(shards_folder(folder)) / "run.json").string();
}

Json to_json(const RunRecord& run) {
  return {{"schema", 1},
          {"command", run.command},
          {"scheduler", run.scheduler},
          {"shards", run.shards},
          {"work", run.work}};
}

// Returns what tasks must agree on, which is everything but the scheduler.
Json agreed(const RunRecord& run) {
  return {{"command", run.command}, {"shards", run.shards}, {"work", run.work}};
}

std::string value_at(const Json& json, const Json::json_pointer& at) {
  return json.contains(at) ? scenes::json_text(json[at]) : "absent";
}

// Describes the first difference of two runs, as "shards is 4 there and 3 here"; "" where there is none.
std::string difference(const Json& there, const Json& here) {
  const Json all = Json::diff(there, here);
  if (all.empty()) return "";
  const std::string path = all.at(0).at("path").get<std::string>();
  const Json::json_pointer at(path);
  // Omits the first part of the path: names inside "work" are clear without it.
  const size_t second = path.find('/', 1);
  std::string name = path.substr(second == std::string::npos ? 1 : second + 1);
  for (char& c : name)
    if (c == '/') c = ' ';
  return fmt::format("{} is {} there and {} here", name, value_at(there, at), value_at(here, at));
}

}  // namespace

std::string shards_folder(const std::string& folder) {
  return (fs::path(folder) / "shards").string();
}

RunRecord read_run(const std::string& folder) {
  const std::string path = record_path(folder);
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored))
    scenes::refuse("{}: holds no run of many tasks, for there is no {}; give the folder that --shard auto wrote to",
                   folder, path);
  const std::vector<uint8_t> bytes = scenes::read_file(path, most_record_bytes);
  try {
    const Json json = Json::parse(bytes);
    if (json.at("schema") != 1) scenes::refuse("{}: is of another version of the program; use that one", path);
    return {folder, json.at("command"), json.at("scheduler"), json.at("shards"), json.at("work")};
  } catch (const Json::exception&) {
    scenes::refuse("{}: is not the record of a run; remove the folder and start anew", path);
  }
}

void join_run(const RunRecord& run) {
  make_folder(shards_folder(run.folder));
  if (write_text_once(record_path(run.folder), scenes::json_text(to_json(run), 1) + "\n")) return;
  const std::string other = difference(agreed(read_run(run.folder)), agreed(run));
  if (!other.empty())
    wrong_usage("--shard auto: {} holds another run: {}; give what that run has, or another folder", run.folder, other);
}

}  // namespace sideray::cli
