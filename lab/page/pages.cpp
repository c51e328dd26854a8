#include "lab/page/pages.h"

#include <nlohmann/json.hpp>

#include "lab/page/page_sources.h"

namespace sideray::lab {
namespace {

// Returns the data for use inside a script element, which a "<" in a name must not end.
std::string script_text(const nlohmann::ordered_json& data) {
  std::string text;
  for (char c : data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace))
    if (c == '<')
      text += "\\u003c";
    else
      text.push_back(c);
  return text;
}

// Returns the template `html`, in which the file names between braces are replaced by the files' text and the data.
std::string filled(std::string_view html, const nlohmann::ordered_json& data) {
  std::string text;
  for (size_t at = 0; at < html.size();) {
    const size_t open = html.find("{{", at), close = html.find("}}", open);
    text += html.substr(at, open - at);
    if (open == std::string_view::npos) break;
    const std::string_view name = html.substr(open + 2, close - open - 2);
    text += name == "data" ? script_text(data) : std::string(page::source(name));
    at = close + 2;
  }
  return text;
}

}  // namespace

std::string chart_page(const nlohmann::ordered_json& data) {
  return filled(page::source("chart.html"), data);
}

std::string golden_page(const nlohmann::ordered_json& data) {
  return filled(page::source("golden.html"), data);
}

}  // namespace sideray::lab
