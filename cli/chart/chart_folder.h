// Manages the files of a chart: their places, what they depend on, and what an earlier run left. Main thread.
#pragma once

#include <optional>
#include <string>

#include "cli/chart/chart_options.h"
#include "lab/chart/chart_results.h"

namespace sideray::cli {

class ChartFolder {
 public:
  // `made_from`: identifies the run whose files are meant; without it, this program and the scene's files.
  explicit ChartFolder(const ChartOptions& options, const std::optional<lab::Json>& made_from = {});

  // Creates the folder. Throws Error where it cannot be written.
  void prepare() const;
  // Removes rows of an earlier chart with more of them.
  void remove_rows_from(size_t row) const;
  std::string path(const std::string& name) const;

  // Files with the measurements of a row, and of the reference.
  static std::string row_file(size_t row);
  static constexpr const char* reference_file = "rows/reference.json";

  // Relative paths, as in results.json; for a sequence, of the last frame.
  static std::string image(size_t row);
  std::string reference_image() const;
  // Return the file of a picture, or the pattern of a sequence's frames.
  std::string row_output(size_t row) const;
  std::string reference_output() const;
  static std::string motion_output();

  // Returns the identity of the program and of the scene's files.
  const lab::Json& made_from() const { return scene_; }
  // Returns everything that a row's figures depend on.
  lab::Json made_with(const RenderOptions& row) const;

  std::optional<lab::ChartRow> restore_row(size_t row, const lab::Json& made_with) const;
  void save_row(size_t row, const lab::ChartRow& content) const;
  std::optional<lab::ChartReference> restore_reference() const;
  void save_reference(const lab::ChartReference& reference) const;

 private:
  std::string folder_;
  std::optional<FrameRange> frames_;
  lab::Json scene_, reference_;  // what pictures of the scene, and the reference, depend on
};

}  // namespace sideray::cli
