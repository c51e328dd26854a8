// Sweeps that drive methods to where they fail, each against a closed form or an exact oracle; through the public
// interface alone. Main thread: the renderer's context.
#pragma once

#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

// Which pixels of one picture are wrong, top row first. Empty where a measure has no pixels.
struct FailureMap {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> wrong;  // 1 = wrong
};

struct StressRow {
  std::string name, variant;  // of the case; the variant as options
  Json parameters = Json::object();
  std::string measure;
  double value = 0, bound = 0;  // passes up to the bound
  bool is_default = false;      // the variant is what the program does unless told otherwise
  FailureMap map;

  bool pass() const { return value <= bound; }
};

// Cases are run with these.
struct StressStage {
  Renderer& renderer;
  bool quick;              // fewer values, smaller pictures
  uint32_t width, height;  // of every picture
};

struct StressCase {
  std::string name;
  std::string question;  // what is swept and what is counted, in one line
  std::vector<StressRow> (*run)(StressStage& stage);
};

const std::vector<StressCase>& stress_cases();

// Pictures have the size that its cases are measured at.
StressStage stress_stage(Renderer& renderer, bool quick);

// Rows in which what the program does by default is beyond its bound: any of them fails the run.
std::vector<const StressRow*> failing_defaults(const std::vector<StressRow>& rows);

// {"schema", "cases"} (docs/cli.md, stress). What is not finite is refused: every measure is a number.
Json stress_json(const std::vector<StressRow>& rows);

}  // namespace sideray::lab
