// Holds the text of the page's files, compiled into the library (lab/CMakeLists.txt). Any thread.
#pragma once

#include <string_view>

namespace sideray::lab::page {

// Returns the text of the file `name` ("chart.html", "chart.min.js"); empty if there is no such file.
std::string_view source(std::string_view name);

}  // namespace sideray::lab::page
