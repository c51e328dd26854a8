// Runs sweeps that drive methods to where they fail, each against a closed form or an exact oracle, by the public
// interface alone. The main thread calls it, because it uses the renderer's context.
#pragma once

#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

// Marks the wrong pixels of one picture, top row first. Empty if a measure has no pixels.
struct FailureMap {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> wrong;  // 1 = wrong
};

struct StressRow {
  std::string name, variant;  // name of the case; the variant, written as options
  Json parameters = Json::object();
  std::string measure;
  double value = 0, bound = 0;  // passes if value <= bound
  bool is_default = false;      // the program's default variant
  FailureMap map;

  bool pass() const { return value <= bound; }
};

// Holds the settings with which cases run.
struct StressStage {
  Renderer& renderer;
  bool quick;              // fewer values, smaller pictures
  uint32_t width, height;  // of every picture
  bool by_rays;            // without OpenGL
};

struct StressCase {
  std::string name;
  std::string question;  // what is swept and counted, in one line
  std::vector<StressRow> (*run)(StressStage& stage);
  bool of_fragments = false;  // counts results of fragments
};

const std::vector<StressCase>& stress_cases();

// Returns whether a case can run: without OpenGL there are no fragments.
bool has_meaning(const StressCase& stress_case, const StressStage& stage);
// Returns no rows for a case that cannot run.
std::vector<StressRow> run_case(const StressCase& stress_case, StressStage& stage);

// Returns a stage whose pictures have the size for which cases are measured.
StressStage stress_stage(Renderer& renderer, bool quick);

// Returns the rows in which the program's default exceeds its bound; any of them fails the run.
std::vector<const StressRow*> failing_defaults(const std::vector<StressRow>& rows);

// Returns {"schema", "cases"} (docs/cli.md, stress). Refuses values that are not finite, because every measure is a
// number.
Json stress_json(const std::vector<StressRow>& rows);

}  // namespace sideray::lab
