// `sideray status` and `sideray gather`: a run that many tasks share, looked at and put together. Main thread.
#pragma once

#include <string>

namespace sideray::cli {

// Prints what is done, running, missing and failed. Returns 1 while a part is missing or programs are mixed.
int status(const std::string& folder, bool json);

// Checks that all parts are whole and of one program, writes what is made of all of them, and removes what killed tasks
// left. Returns 1, having named what is wrong, where the run is not whole.
int gather(const std::string& folder);

}  // namespace sideray::cli
