// Handles stress cases that shards run separately: a file for each case, and the table and page of all. Main thread.
#pragma once

#include <optional>

#include "cli/options/options.h"
#include "cli/record/run_part.h"
#include "lab/stress/stress.h"

namespace sideray::cli {

// Holds the rows of one case that a program wrote.
struct CaseFile {
  std::string program, device;
  std::vector<lab::StressRow> rows;
};

// Returns DIR/rows/NAME.json.
std::string case_file(const std::string& folder, const std::string& name);
void save_case(const std::string& folder, const std::string& name, bool quick, const CaseFile& content);
// Returns nothing where the file is missing, or of another kind of sweep.
std::optional<CaseFile> restore_case(const std::string& folder, const std::string& name, bool quick);

// Returns all cases if no names are given. Throws UsageError for an unknown name.
std::vector<lab::StressCase> stress_cases_named(const std::vector<std::string>& names);

// Writes results, maps and page, and prints the table. Returns the exit code: 1 where a default fails its bound.
int write_stress(const std::string& folder, const std::vector<lab::StressCase>& cases,
                 const std::vector<lab::StressRow>& rows, const std::string& device);

RunRecord stress_run(const std::string& folder, const TaskShard& shard, const std::vector<lab::StressCase>& cases,
                     const Given& given);
std::vector<RunPart> stress_parts(const RunRecord& run);
// Writes the results of a complete run; returns the exit code. Throws Error.
int gather_stress(const RunRecord& run);
// Does the same for cases whose files all exist and are of this program; otherwise returns nothing.
std::optional<int> gather_cases(const std::string& folder, const std::vector<lab::StressCase>& cases, bool quick);

}  // namespace sideray::cli
