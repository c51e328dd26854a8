#include "cli/chart/chart_run.h"

#include <new>
#include <optional>

#include "cli/base/failure.h"
#include "cli/chart/chart_report.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

// Returns the program that a row's file names; "" where there is no such file.
std::string program_of(const std::string& file) {
  try {
    constexpr uint64_t most_bytes = uint64_t{16} << 20;
    return Json::parse(scenes::read_file(file, most_bytes)).at("made_with").at("made_from").at("program");
  } catch (const std::bad_alloc&) {
    throw;  // out of memory says nothing about the file
  } catch (const std::exception&) {
    return "";
  }
}

class RecordedChart {
 public:
  explicit RecordedChart(const RunRecord& run) : run_(run), options_(options_of(run)), images_(options_) {
    const Json& points = run.work.at("points");
    for (size_t i = 0; i < points.size(); ++i) {
      configurations_.push_back(points[i].get<lab::Configuration>());
      rows_.push_back(
          resolve_row(options_, configurations_[i], fmt::format("point {}", i), images_.path(images_.row_output(i))));
    }
  }

  const ChartOptions& options() const { return options_; }
  size_t size() const { return rows_.size(); }

  // Returns the folder, for files that `program` made.
  ChartFolder folder(const std::string& program) const {
    Json made_from = {{"program", program}};
    made_from.update(run_.work.at("made_from"));
    return ChartFolder(options_, made_from);
  }

  std::optional<lab::ChartRow> row(size_t i, const std::string& program) const {
    const ChartFolder files = folder(program);
    std::optional<lab::ChartRow> row = files.restore_row(i, files.made_with(rows_[i]));
    if (!row || row->rounds() < options_.repeats) return {};
    return row;
  }

  RunPart row_part(size_t i) const {
    RunPart part{i, static_cast<uint32_t>(i % run_.shards), images_.path(ChartFolder::row_file(i)), "", ""};
    const std::string program = program_of(part.file);
    if (const std::optional<lab::ChartRow> made = row(i, program)) {
      part.program = program;
      part.device = made->stats.value(Json::json_pointer("/device/renderer"), "");
    }
    return part;
  }

  // Returns the reference's part. Every task needs the reference, and draws it if it is missing.
  RunPart reference_part() const {
    RunPart part{"reference", 0, images_.path(ChartFolder::reference_file), "", ""};
    const std::string program = program_of(part.file);
    if (folder(program).restore_reference()) part.program = program;
    return part;
  }

  std::vector<PagePoint> shown() const {
    std::vector<PagePoint> points;
    for (size_t i = 0; i < rows_.size(); ++i) points.push_back({lab::describe(configurations_[i]), &rows_[i]});
    return points;
  }

 private:
  static ChartOptions options_of(const RunRecord& run) {
    Given given = run.work.at("options").get<Given>();
    given["o"] = run.folder;
    return resolve_chart(run.work.at("scene").get<std::string>(), given);
  }

  const RunRecord& run_;
  ChartOptions options_;
  ChartFolder images_;  // names files, whichever program made them
  std::vector<lab::Configuration> configurations_;
  std::vector<RenderOptions> rows_;
};

}  // namespace

RunRecord chart_run(const ChartOptions& options, const ChartFolder& folder,
                    std::span<const lab::Configuration> configurations) {
  RunRecord run{options.folder, "chart", options.shard.scheduler, options.shard.count, {{"scene", options.scene}}};
  run.work["options"] = Json::object();
  for (const auto& [name, text] : options.given)
    if (name != "o" && name != "shard" && name != "resume") run.work["options"][name] = text;
  // Leaves the program out: rows of different programs are found when they are gathered.
  run.work["made_from"] = folder.made_from();
  run.work["made_from"].erase("program");
  run.work["points"] = Json::array();
  for (const lab::Configuration& configuration : configurations) run.work["points"].push_back(configuration);
  return run;
}

std::vector<RunPart> chart_parts(const RunRecord& run) {
  const RecordedChart chart(run);
  std::vector<RunPart> parts{chart.reference_part()};
  for (size_t i = 0; i < chart.size(); ++i) parts.push_back(chart.row_part(i));
  return parts;
}

// Returns a part that was complete when the run was surveyed. Throws Error where it is gone since.
template <typename T>
T read_again(std::optional<T> found, const RunRecord& run, const std::string& what) {
  if (!found)
    scenes::refuse("{}: {} cannot be read any more; see that nothing else changes the folder, and gather again",
                   run.folder, what);
  return *std::move(found);
}

int gather_chart(const RunRecord& run, const std::string& program) {
  const RecordedChart chart(run);
  const ChartFolder folder = chart.folder(program);
  std::vector<lab::ChartRow> rows;
  for (size_t i = 0; i < chart.size(); ++i)
    rows.push_back(read_again(chart.row(i, program), run, fmt::format("row {}", i)));
  return write_chart(chart.options(), folder, read_again(folder.restore_reference(), run, "the reference"),
                     chart.shown(), rows, Json());
}

}  // namespace sideray::cli
