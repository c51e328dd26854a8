// `sideray golden`: draws reference pictures again and compares. Main thread.
#pragma once

#include <string>
#include <vector>

#include "cli/options/options.h"

namespace sideray::cli {

// Exit code where pictures differ from their references.
constexpr int exit_differs = 3;

// Options: --jobs and those of drawing; --junit, --page, --threads.
const Table& golden_record_table();
const Table& golden_check_table();

// Draws every job and makes its pictures the references, all or none. Throws UsageError or Error.
int golden_record(const std::string& folder, const Given& given);
// Draws the recorded jobs again; pictures that differ are kept in the folder "check". Returns exit_ok or exit_differs.
// Throws UsageError or Error.
int golden_check(const std::string& folder, const Given& given);
// Makes pictures of the last check the references; without names, all that differed. Pictures of another driver than
// the recorded one are not taken: their difference becomes the bound for that driver.
int golden_approve(const std::string& folder, const std::vector<std::string>& names);

}  // namespace sideray::cli
