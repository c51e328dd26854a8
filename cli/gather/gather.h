// `sideray status` and `sideray gather`: inspect and combine a run that many tasks share. Main thread.
#pragma once

#include <string>

namespace sideray::cli {

// Prints what is done, running, missing and failed. Returns 1 while a part is missing or several programs made parts.
int status(const std::string& folder, bool json);

// Checks that all parts are complete and of one program, writes what is made of all of them, and removes what killed
// tasks left. Returns 1, after naming the fault, where the run is not complete.
int gather(const std::string& folder);

}  // namespace sideray::cli
