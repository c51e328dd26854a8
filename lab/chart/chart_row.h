// Holds the measurements of one point of a chart, and its file, which is complete after every round so that a later run
// can continue. Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

struct ChartRow {
  Json made_with;  // the inputs that the row depends on; a row made with others is not reused
  Json stats;      // of the last round (docs/cli.md); null before the first
  Json error;      // metrics against the reference
  std::string image;
  std::map<std::string, std::vector<double>> rounds_ms;  // stage -> one time for each frame and round
  size_t frames = 1;                                     // in each round

  size_t rounds() const;
  // `round`: statistics of each of its frames, timed once.
  void add_round(const std::vector<Json>& round);
  void add_round(Json picture) { add_round(std::vector<Json>{std::move(picture)}); }
};

Json to_json(const ChartRow& row);
// Returns nothing if the text is no row, or one made with other inputs.
std::optional<ChartRow> parse_row(const std::string& text, const Json& made_with);

// Returns the last frame's statistics, with the median over all frames for counters; of an even number of frames, the
// lower of the two middle values.
Json median_stats(const std::vector<Json>& frames);

struct Quartiles {
  double p25 = 0, median = 0, p75 = 0;
};
// Interpolates linearly between order statistics, as in the statistics of `render`; zeros without values.
Quartiles quartiles(std::vector<double> values);

}  // namespace sideray::lab
