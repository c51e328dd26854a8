#include <filesystem>
#include <map>

#include "cli/base/failure.h"
#include "cli/options/configuration_files.h"
#include "cli/render/render.h"
#include "cli/session/session.h"

namespace sideray::cli {
namespace {

Given job_given(const lab::Configuration& job, const std::string& name) {
  for (const char* option : {"jobs", "compare", "json"})
    if (job.contains(option)) wrong_usage("{}: {} does not belong in a job; remove it", name, option);
  return given_of(job, name);
}

RenderOptions resolve_job(Given given, const Given& defaults, const std::string& name) {
  given.insert(defaults.begin(), defaults.end());
  const std::string scene = given["scene"];
  given.erase("scene");
  try {
    return resolve_render(scene, given);
  } catch (const UsageError& error) {
    wrong_usage("{}: {}", name, error.what());
  }
}

std::string job_name(const std::string& path, size_t index) {
  return fmt::format("{} job {}", path, index);
}

// Its errors name the job.
template <typename Work>
auto of_job(const std::string& name, const Work& work) {
  try {
    return work();
  } catch (const UsageError& error) {
    wrong_usage("{}: {}", name, error.what());
  } catch (const Error& error) {
    throw Error(error.status, fmt::format("{}: {}", name, error.what()));
  }
}

// The last of two jobs with one output would win silently.
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

int render_jobs(const std::string& path, const Given& defaults) {
  std::vector<RenderOptions> renders;
  const std::vector<lab::Configuration> jobs = read_configurations(path, "job");
  if (jobs.empty()) wrong_usage("{}: holds no job; write [{{\"scene\": \"...\", \"o\": \"...\"}}, ...]", path);
  for (size_t i = 0; i < jobs.size(); ++i) {
    const std::string name = job_name(path, i);
    renders.push_back(resolve_job(job_given(jobs[i], name), defaults, name));
  }
  require_outputs_apart(renders, path);
  check_renders(renders, path);
  for (size_t i = 0; i < renders.size(); ++i)
    if (const int code = of_job(job_name(path, i), [&] { return render(renders[i]); }); code != exit_ok) return code;
  return exit_ok;
}

}  // namespace sideray::cli
