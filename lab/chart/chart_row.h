// Holds one point of a chart while it is measured, and its file, which is complete after every round, so that a later
// run continues from it. Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

struct ChartRow {
  Json made_with;  // everything the row depends on; a different value makes another row
  Json stats;      // of the last round (docs/cli.md); null before the first
  Json error;      // metrics against the reference
  std::string image;
  std::map<std::string, std::vector<double>> rounds_ms;  // stage -> one time a frame and round
  size_t frames = 1;                                     // in each round

  size_t rounds() const;
  // Adds a round: the stats of each frame, timed once.
  void add_round(const std::vector<Json>& round);
  void add_round(Json picture) { add_round(std::vector<Json>{std::move(picture)}); }
};

Json to_json(const ChartRow& row);
// Returns nothing where the text is no row, or one with another `made_with`.
std::optional<ChartRow> parse_row(const std::string& text, const Json& made_with);

// Returns the stats of the last frame, with every count replaced by its median over all frames (the lower median for an
// even number of frames).
Json median_stats(const std::vector<Json>& frames);

struct Quartiles {
  double p25 = 0, median = 0, p75 = 0;
};
// Interpolates linearly between order statistics, as the stats of `render` do. Returns zeros for no values.
Quartiles quartiles(std::vector<double> values);

}  // namespace sideray::lab
