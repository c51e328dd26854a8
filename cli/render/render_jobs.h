// Turns a --jobs file into renders, for all commands that draw one. Any thread.
#pragma once

#include <optional>
#include <vector>

#include "cli/base/failure.h"
#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

// Returns "FILE job INDEX", for errors.
std::string job_name(const std::string& path, size_t index);

// Runs `work`, whose errors then name the job.
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

// `defaults` apply to every job that does not set them; sequences get `shard`, if any. Throws UsageError, also where
// there is no job, or two write the same file.
std::vector<RenderOptions> resolve_jobs(const std::vector<lab::Configuration>& jobs, const std::string& path,
                                        const Given& defaults, const std::optional<TaskShard>& shard = {});

}  // namespace sideray::cli
