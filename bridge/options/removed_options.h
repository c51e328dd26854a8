// Lists names and values of options that earlier versions had, each with its replacement, or with the value that it is
// read as. The next version removes the list. Any thread.
#pragma once

#include <string>

namespace sideray::bridge {

// Returns the replacement of a removed option, as static text; null where no earlier version had it.
const char* removed_option(const std::string& name);
// Does the same for one value of an option that still exists.
const char* removed_value(const std::string& name, const std::string& value);
// Returns the value that a former option, or a former value of an option, is still read as, in static text; "" where it
// has no effect any more, null where it is not accepted.
const char* read_as(const std::string& name, const std::string& value);

}  // namespace sideray::bridge
