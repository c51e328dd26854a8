#include "cli/render/render_jobs.h"

#include <filesystem>
#include <map>

#include "cli/base/failure.h"
#include "cli/options/configuration_files.h"
#include "cli/render/render.h"
#include "cli/render/render_run.h"
#include "cli/session/session.h"

namespace sideray::cli {
namespace {

Given job_given(const lab::Configuration& job, const std::string& name) {
  for (const char* option : {"jobs", "compare"})
    if (job.contains(option)) wrong_usage("{}: {} does not belong in a job; remove it", name, option);
  return given_of(job, name);
}

// Sets the task's shard, which is the same for all jobs.
void set_shard(Given& given, const std::optional<TaskShard>& shard, const std::string& name) {
  const auto own = given.find("shard");
  if (own != given.end() && ((shard && shard->is_recorded()) || own->second.starts_with("auto")))
    wrong_usage("{}: shard auto holds for all jobs; give it on the command line alone", name);
  if (shard && given.contains("frames")) given.emplace("shard", fmt::format("{}/{}", shard->index, shard->count));
}

RenderOptions resolve_job(Given given, const Given& defaults, const std::optional<TaskShard>& shard,
                          const std::string& name) {
  given.insert(defaults.begin(), defaults.end());
  set_shard(given, shard, name);
  const std::string scene = given["scene"];
  given.erase("scene");
  try {
    return resolve_render(scene, given);
  } catch (const UsageError& error) {
    wrong_usage("{}: {}", name, error.what());
  }
}

// Refuses two jobs with one output, of which the last would win silently.
void require_outputs_apart(const std::vector<RenderOptions>& renders, const std::string& path) {
  std::map<std::filesystem::path, size_t> writers;
  for (size_t i = 0; i < renders.size(); ++i)
    for (const std::string& file : {renders[i].output, renders[i].stats}) {
      if (file.empty()) continue;
      std::error_code ignored;
      const auto [other, first] =
          writers.emplace(std::filesystem::weakly_canonical(std::filesystem::absolute(file), ignored), i);
      if (!first && other->second != i)
        wrong_usage("{}: writes {} as job {} does; choose another name", job_name(path, i), file, other->second);
    }
}

void check_renders(const std::vector<RenderOptions>& renders, const std::string& path) {
  SceneChecks scenes;
  for (size_t i = 0; i < renders.size(); ++i)
    of_job(job_name(path, i), [&] {
      check_render(renders[i]);
      scenes.check(renders[i]);
    });
}

}  // namespace

std::string job_name(const std::string& path, size_t index) {
  return fmt::format("{} job {}", path, index);
}

std::vector<RenderOptions> resolve_jobs(const std::vector<lab::Configuration>& jobs, const std::string& path,
                                        const Given& defaults, const std::optional<TaskShard>& shard) {
  std::vector<RenderOptions> renders;
  if (jobs.empty()) wrong_usage("{}: holds no job; write [{{\"scene\": \"...\", \"o\": \"...\"}}, ...]", path);
  for (size_t i = 0; i < jobs.size(); ++i) {
    const std::string name = job_name(path, i);
    renders.push_back(resolve_job(job_given(jobs[i], name), defaults, shard, name));
  }
  require_outputs_apart(renders, path);
  return renders;
}

int render_jobs(const std::string& path, const Given& given) {
  Given defaults = given;
  std::optional<TaskShard> shard;
  if (const auto text = defaults.extract("shard")) shard = parse_shard(text.mapped());
  std::vector<RenderOptions> renders = resolve_jobs(read_configurations(path, "job"), path, defaults, shard);
  const bool is_run = shard && shard->is_recorded();
  if (is_run) prepare_run(renders);
  check_renders(renders, path);
  const auto draw = [&](size_t i, const RunJob* job) {
    return of_job(job_name(path, i), [&] { return render(renders[i], job); });
  };
  if (is_run) return render_run(renders, *shard, [&](size_t i, const RunJob& job) { return draw(i, &job); });
  for (size_t i = 0; i < renders.size(); ++i) {
    if (shard && !renders[i].frames && !is_of_shard(i, *shard)) continue;
    if (const int code = draw(i, nullptr); code != exit_ok) return code;
  }
  return exit_ok;
}

}  // namespace sideray::cli
