#include "cli/options/shard.h"

#include <charconv>
#include <cstdlib>
#include <optional>

#include "cli/base/failure.h"
#include "cli/options/options.h"

namespace sideray::cli {
namespace {

constexpr uint32_t most_shards = 1000000;
constexpr const char *slurm_id = "SLURM_ARRAY_TASK_ID", *kubernetes_id = "JOB_COMPLETION_INDEX",
                     *gridengine_id = "SGE_TASK_ID";

// Returns an environment variable. GridEngine sets "undefined" where a job has no tasks.
std::optional<std::string> variable(const char* name) {
  const char* text = std::getenv(name);
  if (!text || !*text || std::string(text) == "undefined") return {};
  return text;
}

uint32_t number_in(const char* name, uint32_t low, uint32_t high = UINT32_MAX) {
  const std::optional<std::string> text = variable(name);
  if (!text) wrong_usage("--shard auto: {} is not set; give --shard auto/N with the number of all tasks", name);
  uint32_t value = 0;
  const char* end = text->data() + text->size();
  const auto [stop, error] = std::from_chars(text->data(), end, value);
  if (error != std::errc() || stop != end || value < low || value > high)
    wrong_usage("--shard auto: {} is \"{}\", and not a whole number from {} to {}; unset or correct it", name, *text,
                low, high);
  return value;
}

Shard shard_among(const char* name, uint32_t first, uint32_t count) {
  const uint32_t id = number_in(name, 0);
  if (id < first || id - first >= count)
    wrong_usage("--shard auto/{}: {} is {}; number the tasks {} to {}", count, name, id, first, count - 1 + first);
  return {id - first, count};
}

// Refuses lists such as 2,5: the smallest number and the count do not tell which numbers are between.
Shard slurm_shard(std::optional<uint32_t> count) {
  if (count) return shard_among(slurm_id, 0, *count);
  const uint32_t id = number_in(slurm_id, 0), first = number_in("SLURM_ARRAY_TASK_MIN", 0),
                 step = number_in("SLURM_ARRAY_TASK_STEP", 1),
                 tasks = number_in("SLURM_ARRAY_TASK_COUNT", 1, most_shards);
  const uint64_t last = first + uint64_t{step} * (tasks - 1);
  if (id < first || (id - first) % step != 0 || id > last)
    wrong_usage(
        "--shard auto: SLURM_ARRAY_TASK_ID is {}, and {} tasks from {} on in steps of {} have no such one; for a "
        "list of tasks give --shard auto/N, with the N of all of them",
        id, tasks, first, step);
  if (variable("SLURM_ARRAY_TASK_MAX") && number_in("SLURM_ARRAY_TASK_MAX", 0) != last)
    wrong_usage(
        "--shard auto: SLURM_ARRAY_TASK_MAX is {}, where {} tasks from {} on in steps of {} end at {}; for a list "
        "of tasks give --shard auto/N, with the N of all of them",
        *variable("SLURM_ARRAY_TASK_MAX"), tasks, first, step, last);
  return {(id - first) / step, tasks};
}

Shard kubernetes_shard(std::optional<uint32_t> count) {
  constexpr const char* name = "JOB_COMPLETION_COUNT";
  if (!count) count = number_in(name, 1, most_shards);
  if (variable(name) && number_in(name, 1, most_shards) != *count)
    wrong_usage("--shard auto/{}: {} is {}; give one of the two", *count, name, *variable(name));
  return shard_among(kubernetes_id, 0, *count);
}

Shard gridengine_shard(std::optional<uint32_t> count) {
  if (!count) wrong_usage("--shard auto: GridEngine gives no count; give --shard auto/N, with the N of qsub -t 1-N");
  if (variable("SGE_TASK_STEPSIZE") && number_in("SGE_TASK_STEPSIZE", 1) != 1)
    wrong_usage("--shard auto/{}: SGE_TASK_STEPSIZE is {}; number the tasks one by one, qsub -t 1-{}", *count,
                *variable("SGE_TASK_STEPSIZE"), *count);
  return shard_among(gridengine_id, 1, *count);
}

TaskShard scheduled_shard(std::optional<uint32_t> count) {
  struct Scheduler {
    const char *name, *id;
    Shard (*shard)(std::optional<uint32_t> count);
  };
  const Scheduler* found = nullptr;
  static constexpr Scheduler schedulers[] = {{"slurm", slurm_id, slurm_shard},
                                             {"kubernetes", kubernetes_id, kubernetes_shard},
                                             {"gridengine", gridengine_id, gridengine_shard}};
  for (const Scheduler& scheduler : schedulers) {
    if (!variable(scheduler.id)) continue;
    if (found) wrong_usage("--shard auto: both {} and {} are set; unset one of them", found->id, scheduler.id);
    found = &scheduler;
  }
  if (!found)
    wrong_usage("--shard auto: neither {}, {} nor {} is set; run it as a task of an array, or give --shard I/N",
                slurm_id, kubernetes_id, gridengine_id);
  return {found->shard(count), found->name};
}

}  // namespace

TaskShard parse_shard(const std::string& text) {
  if (text == "auto") return scheduled_shard({});
  const std::vector<std::string> parts = split(text, '/');
  if (parts.size() != 2 || parts[0].empty() || parts[1].empty())
    wrong_usage("--shard: \"{}\" is not I/N; write for example 0/4, or auto", text);
  const uint32_t count = whole_number("shard", parts[1], 1, most_shards);
  if (parts[0] == "auto") return scheduled_shard(count);
  return {{whole_number("shard", parts[0], 0, count - 1), count}, ""};
}

}  // namespace sideray::cli
