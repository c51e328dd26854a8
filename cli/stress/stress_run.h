// The stress cases that shards run apart: a file a case, and the table and page of all of them. Main thread.
#pragma once

#include <optional>

#include "cli/options/options.h"
#include "cli/record/run_part.h"
#include "lab/stress/stress.h"

namespace sideray::cli {

// The rows of one case as a program left them.
struct CaseFile {
  std::string program, device;
  std::vector<lab::StressRow> rows;
};

// DIR/rows/NAME.json
std::string case_file(const std::string& folder, const std::string& name);
void save_case(const std::string& folder, const std::string& name, bool quick, const CaseFile& content);
// Empty where it is not there, or of another kind of sweep.
std::optional<CaseFile> restore_case(const std::string& folder, const std::string& name, bool quick);

// Throws UsageError for a name that there is not; all cases where none is named.
std::vector<lab::StressCase> stress_cases_named(const std::vector<std::string>& names);

// Writes results, maps and page, and prints the table. Returns the exit code: 1 where a default fails its bound.
int write_stress(const std::string& folder, const std::vector<lab::StressCase>& cases,
                 const std::vector<lab::StressRow>& rows, const std::string& device);

RunRecord stress_run(const std::string& folder, const TaskShard& shard, const std::vector<lab::StressCase>& cases,
                     const Given& given);
std::vector<RunPart> stress_parts(const RunRecord& run);
// Writes the results of a run that is whole; returns the exit code. Throws Error.
int gather_stress(const RunRecord& run);
// The same of cases whose files are all there and of this program; empty where they are not.
std::optional<int> gather_cases(const std::string& folder, const std::vector<lab::StressCase>& cases, bool quick);

}  // namespace sideray::cli
