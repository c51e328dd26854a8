// One point of a chart as it is measured, and its file: whole after every round, so that a later run goes on from it.
// Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace sideray::lab {

using Json = nlohmann::ordered_json;

struct ChartRow {
  Json made_with;  // what the row depends on: one made with anything else is another row
  Json stats;      // of the last round (docs/cli.md); null before the first
  Json error;      // metrics against the reference
  std::string image;
  std::map<std::string, std::vector<double>> rounds_ms;  // stage -> one time a frame and round
  size_t frames = 1;                                     // in each round

  size_t rounds() const;
  // `round`: the stats of each of its frames, timed once.
  void add_round(const std::vector<Json>& round);
  void add_round(Json picture) { add_round(std::vector<Json>{std::move(picture)}); }
};

Json to_json(const ChartRow& row);
// Empty where the text is no row, or one made with something else.
std::optional<ChartRow> parse_row(const std::string& text, const Json& made_with);

// Of the frames' stats those of the last one, with the median over all of what is counted; of an even number of frames
// the lower of the two in the middle.
Json median_stats(const std::vector<Json>& frames);

struct Quartiles {
  double p25 = 0, median = 0, p75 = 0;
};
// By linear interpolation between order statistics, as in the stats of `render`; zeros for no values.
Quartiles quartiles(std::vector<double> values);

}  // namespace sideray::lab
