// Runs sweeps that drive methods to where they fail, each against a closed form or an exact oracle, through the public
// interface alone. The main thread calls it: it uses the renderer's context.
#pragma once

#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

// Marks which pixels of one picture are wrong, top row first. Empty where a measure has no pixels.
struct FailureMap {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> wrong;  // 1 = wrong
};

struct StressRow {
  std::string name, variant;  // name of the case; the variant as options
  Json parameters = Json::object();
  std::string measure;
  double value = 0, bound = 0;  // passes up to the bound
  bool is_default = false;      // the program uses the variant by default
  FailureMap map;

  bool pass() const { return value <= bound; }
};

// Holds what cases are run with.
struct StressStage {
  Renderer& renderer;
  bool quick;              // fewer values, smaller pictures
  uint32_t width, height;  // of every picture
  bool by_rays;            // without OpenGL
};

struct StressCase {
  std::string name;
  std::string question;  // what is swept and what is counted, in one line
  std::vector<StressRow> (*run)(StressStage& stage);
  bool of_fragments = false;  // it counts what fragments take
};

const std::vector<StressCase>& stress_cases();

// Whether a case can be run: without OpenGL nothing draws fragments.
bool has_meaning(const StressCase& stress_case, const StressStage& stage);
// Returns no row of a case that has none.
std::vector<StressRow> run_case(const StressCase& stress_case, StressStage& stage);

// Pictures have the size that its cases are measured at.
StressStage stress_stage(Renderer& renderer, bool quick);

// Returns rows in which the program's default is beyond its bound: any of them fails the run.
std::vector<const StressRow*> failing_defaults(const std::vector<StressRow>& rows);

// Returns {"schema", "cases"} (docs/cli.md, stress). Refuses what is not finite: every measure is a number.
Json stress_json(const std::vector<StressRow>& rows);

}  // namespace sideray::lab
