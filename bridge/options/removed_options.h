// Names and values of options that an earlier version had: what to write instead, or what they are read as. They go with the
// next version.
// Any thread.
#pragma once

#include <string>

namespace sideray::bridge {

// Returns what to write instead, static text; null where no earlier version had the option.
const char* removed_option(const std::string& name);
// The same of one value of an option that is still there.
const char* removed_value(const std::string& name, const std::string& value);
// Returns the value that an option of an earlier version, or a value of one, is still read as, static text; "" where it has
// no effect any more, null where it is not.
const char* read_as(const std::string& name, const std::string& value);

}  // namespace sideray::bridge
