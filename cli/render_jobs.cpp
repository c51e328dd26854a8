#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>

#include "failure.h"
#include "render.h"
#include "scenes/files.h"

namespace sideray::cli {
namespace {

nlohmann::json read_jobs(const std::string& path) {
  constexpr uint64_t most_bytes = uint64_t{64} << 20;
  const std::vector<uint8_t> bytes = scenes::read_file(path, most_bytes);
  nlohmann::json jobs;
  try {
    jobs = nlohmann::json::parse(bytes);
  } catch (const nlohmann::json::parse_error& error) {
    scenes::refuse("{}: is not JSON from byte {} on; correct it", path, error.byte);
  }
  if (!jobs.is_array()) wrong_usage("{}: is not an array; write [{{\"scene\": ..., \"o\": ...}}, ...]", path);
  return jobs;
}

// false leaves an option out: flags have no other way to be off.
Given given_of(const nlohmann::json& job, const std::string& name) {
  if (!job.is_object()) wrong_usage("{}: is not an object; write {{\"scene\": ..., \"o\": ...}}", name);
  Given given;
  for (const auto& [key, value] : job.items()) {
    if (key == "jobs" || key == "compare" || key == "json")
      wrong_usage("{}: {} does not belong in a job; remove it", name, key);
    if (value.is_string())
      given[key] = value.get<std::string>();
    else if (value.is_number())
      given[key] = value.dump();
    else if (value.is_boolean() && value.get<bool>())
      given[key] = "true";
    else if (!value.is_boolean())
      wrong_usage("{}: {} is neither text, number, true nor false; correct it", name, key);
  }
  return given;
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

int run_job(const RenderOptions& options, const std::string& name) {
  try {
    return render(options);
  } catch (const UsageError& error) {
    wrong_usage("{}: {}", name, error.what());
  } catch (const Error& error) {
    throw Error(error.status, fmt::format("{}: {}", name, error.what()));
  }
}

}  // namespace

int render_jobs(const std::string& path, const Given& defaults) {
  std::vector<RenderOptions> renders;
  const nlohmann::json jobs = read_jobs(path);
  for (size_t i = 0; i < jobs.size(); ++i) {
    const std::string name = job_name(path, i);
    renders.push_back(resolve_job(given_of(jobs[i], name), defaults, name));
  }
  for (size_t i = 0; i < renders.size(); ++i)
    if (const int code = run_job(renders[i], job_name(path, i)); code != exit_ok) return code;
  return exit_ok;
}

}  // namespace sideray::cli
