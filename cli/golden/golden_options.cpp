#include <string_view>

#include "cli/golden/golden.h"
#include "cli/golden/golden_jobs.h"
#include "cli/options/render_table.h"

namespace sideray::cli {
namespace {

bool is_of_record(const OwnOption& own) {
  const std::string_view name = own.row.name;
  return name == "jobs" || (own.in_plan && !depends_on_time(own.row.name));
}

}  // namespace

const Table& golden_record_table() {
  static const Table table =
      picture_table([](const sideray_option& option) { return !depends_on_time(option.name); }, is_of_record);
  return table;
}

const Table& golden_check_table() {
  static const sideray_option rows[] = {text_row("junit", "FILE.xml", "", "writes the results as JUnit does"),
                                        text_row("page", "FILE.html", "", "the page to write [DIR/check.html]")};
  static const Table table{&rows[0], &rows[1], &find_own("threads")->row};
  return table;
}

}  // namespace sideray::cli
