// The text of the files of the page, compiled into the library (lab/CMakeLists.txt). Any thread.
#pragma once

#include <string_view>

namespace sideray::lab::page {

// Returns the text of the file `name` ("chart.html", "chart.min.js"); empty where there is no such file.
std::string_view source(std::string_view name);

}  // namespace sideray::lab::page
