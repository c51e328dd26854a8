#include "cli/gather/survey.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include "cli/chart/chart_run.h"
#include "cli/render/run_pictures.h"
#include "cli/stress/stress_run.h"

namespace sideray::cli {
namespace {

std::vector<RunPart> parts_of(const RunRecord& run, bool reads_all) {
  if (run.command == "render") return picture_parts(run, reads_all);
  return run.command == "chart" ? chart_parts(run) : stress_parts(run);
}

// Returns "3", "5-7" for ascending numbers.
std::vector<std::string> ranges(const std::vector<uint32_t>& numbers) {
  std::vector<std::string> texts;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    texts.push_back(end == i + 1 ? std::to_string(numbers[i]) : fmt::format("{}-{}", numbers[i], numbers[end - 1]));
    i = end;
  }
  return texts;
}

}  // namespace

std::map<std::string, std::vector<Json>> Survey::programs() const {
  std::map<std::string, std::vector<Json>> programs;
  for (const RunPart& part : parts)
    if (!part.program.empty()) programs[part.program].push_back(part.name);
  return programs;
}

std::vector<Json> Survey::missing(const std::string& state) const {
  std::vector<Json> names;
  for (const RunPart& part : parts) {
    const std::optional<TaskNote>& task = tasks[part.shard];
    if (part.program.empty() && (state.empty() || (task && task->state == state))) names.push_back(part.name);
  }
  return names;
}

std::vector<uint32_t> Survey::to_run_again() const {
  const std::map<std::string, std::vector<Json>> all = programs();
  const auto most = std::max_element(all.begin(), all.end(),
                                     [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  std::vector<bool> again(run.shards);
  for (const RunPart& part : parts)
    if (part.program.empty() || part.program != most->first) again[part.shard] = true;
  std::vector<uint32_t> shards;
  for (uint32_t shard = 0; shard < run.shards; ++shard)
    if (again[shard] && !(tasks[shard] && tasks[shard]->state == "running")) shards.push_back(shard);
  return shards;
}

Survey survey(const std::string& folder, bool reads_all) {
  Survey result{read_run(folder), {}, {}};
  result.parts = parts_of(result.run, reads_all);
  for (uint32_t shard = 0; shard < result.run.shards; ++shard) result.tasks.push_back(read_task(folder, shard));
  return result;
}

std::string listed(const std::vector<Json>& names) {
  constexpr size_t most = 20;
  std::vector<uint32_t> numbers;
  std::vector<std::string> texts;
  for (const Json& name : names) {
    if (name.is_number())
      numbers.push_back(name.get<uint32_t>());
    else
      texts.push_back(name.get<std::string>());
  }
  for (std::string& range : ranges(numbers)) texts.push_back(std::move(range));
  const size_t left_out = texts.size() > most ? texts.size() - most : 0;
  texts.resize(texts.size() - left_out);
  return fmt::format("{}{}", fmt::join(texts, ", "), left_out > 0 ? fmt::format(" and {} more", left_out) : "");
}

std::string retry_command(const Survey& survey) {
  const std::vector<uint32_t> shards = survey.to_run_again();
  if (shards.empty()) return "";
  const std::string list = fmt::format("{}", fmt::join(ranges(shards), ","));
  if (survey.run.scheduler == "slurm") return "sbatch --array=" + list;
  if (survey.run.scheduler == "kubernetes") return "indexes " + list;
  std::string commands;
  for (const uint32_t shard : shards) commands += fmt::format("{}qsub -t {}", commands.empty() ? "" : "; ", shard + 1);
  return commands;
}

}  // namespace sideray::cli
