// Which program this is. Any thread.
#pragma once

#include <string>

namespace sideray::cli {

// For example "0.3.0".
std::string program_version();

// The version and a hash of the program's file and of the libraries of its own that it has loaded: another build is
// another program, and may draw another picture.
const std::string& program_build();

}  // namespace sideray::cli
