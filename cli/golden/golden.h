// `sideray golden`: pictures that a folder keeps as references, drawn again and compared. Main thread.
#pragma once

#include <string>
#include <vector>

#include "cli/options/options.h"

namespace sideray::cli {

// The code where pictures differ from their references.
constexpr int exit_differs = 3;

// --jobs and what says how pictures are drawn; --junit, --page, --threads.
const Table& golden_record_table();
const Table& golden_check_table();

// Draws every job and makes its pictures the references, all of them or none. Throws UsageError or Error.
int golden_record(const std::string& folder, const Given& given);
// Draws the recorded jobs again; what differs stays in the folder "check". Returns exit_ok or exit_differs. Throws
// UsageError or Error.
int golden_check(const std::string& folder, const Given& given);
// Makes pictures of the last check the references; of none given all that differed. Of another driver than the
// recorded one it allows as much difference instead. Throws UsageError or Error.
int golden_approve(const std::string& folder, const std::vector<std::string>& names);

}  // namespace sideray::cli
