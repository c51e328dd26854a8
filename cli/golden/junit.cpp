#include "cli/golden/junit.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace sideray::cli {
namespace {

// Replaces broken UTF-8 by U+FFFD, as nlohmann's writer does.
std::string valid_utf8(const std::string& text) {
  const nlohmann::json safe = text;
  return nlohmann::json::parse(safe.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

// Escapes text; other control characters become spaces, as XML cannot express them.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : valid_utf8(text)) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      safe += ' ';
    else
      safe += c;
  }
  return safe;
}

std::string case_text(const std::string& suite, const JunitCase& test) {
  const std::string head =
      fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", suite, escaped(test.name), test.seconds);
  if (test.failure.empty()) return head + "/>\n";
  return head + fmt::format(">\n      <failure message=\"{0}\">{0}</failure>\n    </testcase>\n", escaped(test.failure));
}

}  // namespace

std::string junit_text(const std::string& suite, const std::vector<JunitCase>& cases) {
  size_t failures = 0;
  double seconds = 0;
  for (const JunitCase& test : cases) failures += !test.failure.empty(), seconds += test.seconds;
  const std::string name = escaped(suite);
  const std::string counts = fmt::format("tests=\"{}\" failures=\"{}\" time=\"{:.3f}\"", cases.size(), failures, seconds);
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {1}>\n  <testsuite name=\"{0}\" {1} errors=\"0\" "
      "skipped=\"0\">\n",
      name, counts);
  for (const JunitCase& test : cases) text += case_text(name, test);
  return text + "  </testsuite>\n</testsuites>\n";
}

}  // namespace sideray::cli
