// The commands of `sideray`: each adds itself to the parser and returns what to run when it is chosen. Main thread.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace sideray::cli {

// Runs after parsing and returns the exit code. Throws UsageError or sideray::Error.
using Run = std::function<int()>;

struct Command {
  CLI::App* app;
  Run run;
};

Command add_render(CLI::App& program);
Command add_bench(CLI::App& program);
Command add_chart(CLI::App& program);
Command add_stress(CLI::App& program);
Command add_plan(CLI::App& program);
Command add_view(CLI::App& program);
Command add_run(CLI::App& program);
Command add_compare(CLI::App& program);
Command add_info(CLI::App& program);
Command add_make(CLI::App& program);
Command add_status(CLI::App& program);
Command add_gather(CLI::App& program);
Command add_golden(CLI::App& program);
Command add_devices(CLI::App& program);
Command add_option_list(CLI::App& program);

}  // namespace sideray::cli
