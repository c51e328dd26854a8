// Draws the pictures of a ledger, through their files, so that `sideray compare` of two of them says the same. Main
// thread.
#pragma once

#include "cli/chart/chart_folder.h"
#include "cli/plan/ledger_shortcuts.h"
#include "cli/session/session.h"

namespace sideray::cli {

class LedgerPictures {
 public:
  // What is random is the mean of so many pictures.
  static constexpr uint32_t random_pictures = 8;

  LedgerPictures(const ChartOptions& options, const ChartFolder& folder, Session& session);

  static std::string file_of(const std::string& name);  // relative to the folder
  // The configuration given, which everything starts from.
  const RenderOptions& base() const { return base_; }
  Shortcuts find_shortcuts();

  // With other options than those of base(). Throws Error.
  scenes::Image draw(const Shortcut& other);

  // 1 = the reference sees another opaque triangle there, or none, or one where the rasterizer has none; of the first
  // position of each pixel.
  std::vector<uint8_t> differing_pixels();

  // The chart's own, unless base() asks for other light than that.
  lab::ChartReference draw_reference(const lab::ChartReference& of_chart);

 private:
  RenderOptions reference_options() const;
  // The same, but for what the chain's picture says.
  RenderOptions reference_options(const Shortcut& other) const;
  // Adds the step from one bounce to as many as the reference follows: no method of drawing can take it.
  void add_bounces(Shortcuts& shortcuts) const;
  // There is no better matcher than ids to switch to: whether they err is counted instead.
  void add_match(Shortcuts& shortcuts);
  scenes::Image write(const std::string& name, const std::vector<scenes::Plane>& colour, uint32_t pictures) const;
  RenderOptions resolve(const lab::Configuration& configuration, const std::string& name) const;

  const ChartOptions& options_;
  const ChartFolder& folder_;
  Session& session_;
  RenderOptions base_;
};

}  // namespace sideray::cli
