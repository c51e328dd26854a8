#include "cli/options/render_table.h"

#include <cstring>

namespace sideray::cli {

Table picture_table(bool (*keep_library)(const sideray_option&), bool (*keep_own)(const OwnOption&)) {
  Table table;
  const auto add_behind = [&](const char* after) {
    for (const OwnOption& own : own_options())
      if (std::strcmp(own.after, after) == 0 && (!keep_own || keep_own(own))) table.push_back(&own.row);
  };
  add_behind("");
  for (size_t i = 0; i < sideray_option_count(); ++i) {
    const sideray_option* option = sideray_option_at(i);
    if (!keep_library || keep_library(*option)) table.push_back(option);
    add_behind(option->name);
  }
  return table;
}

const Table& render_table() {
  static const Table table = picture_table(nullptr, nullptr);
  return table;
}

}  // namespace sideray::cli
