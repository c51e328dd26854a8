// Prints a plan: as JSON, whose keys docs/cli.md defines, and for people. Any thread.
#pragma once

#include "cli/plan/choice.h"

namespace sideray::cli {

struct PlanReport {
  const RenderOptions& options;  // of the plan: those of the choice, if there was one
  const Session::Planned& planned;
  std::optional<lab::FrameCost> predicted;
  std::optional<Choice> choice;
};

nlohmann::ordered_json plan_json(const PlanReport& report);
void print_plan(const PlanReport& report);

}  // namespace sideray::cli
