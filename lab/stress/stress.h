// Runs sweeps that drive methods to where they fail, and compares each with a closed form or an exact oracle, through
// the public interface alone. Only the main thread may call it, since it uses the renderer's context.
#pragma once

#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

// Marks the wrong pixels of one picture, top row first. Empty for measures that are not of pixels.
struct FailureMap {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> wrong;  // 1 = wrong
};

struct StressRow {
  std::string name, variant;  // name of the case; the variant, written as options
  Json parameters = Json::object();
  std::string measure;
  double value = 0, bound = 0;  // the row passes where value <= bound
  bool is_default = false;      // the program uses the variant by default
  FailureMap map;

  bool pass() const { return value <= bound; }
};

// Holds the renderer and the settings that cases run with.
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
  bool of_fragments = false;  // it needs fragments, which only OpenGL draws
};

const std::vector<StressCase>& stress_cases();

// Returns whether the case can run: without OpenGL nothing draws fragments.
bool has_meaning(const StressCase& stress_case, const StressStage& stage);
// Returns the rows of a case, none where it cannot run.
std::vector<StressRow> run_case(const StressCase& stress_case, StressStage& stage);

// Returns a stage whose pictures have the size at which cases are measured.
StressStage stress_stage(Renderer& renderer, bool quick);

// Returns the rows in which the program's default exceeds its bound. A single one fails the run.
std::vector<const StressRow*> failing_defaults(const std::vector<StressRow>& rows);

// Returns {"schema", "cases"} (docs/cli.md, stress). Throws Error where a value is not finite.
Json stress_json(const std::vector<StressRow>& rows);

}  // namespace sideray::lab
