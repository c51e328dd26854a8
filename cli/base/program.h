// Identifies this program. Any thread.
#pragma once

#include <string>

namespace sideray::cli {

// Returns for example "0.3.0".
std::string program_version();

// Returns the version and a hash of the files of the program and of its own loaded libraries. Another build counts as
// another program, as it may draw other pictures.
const std::string& program_build();

}  // namespace sideray::cli
