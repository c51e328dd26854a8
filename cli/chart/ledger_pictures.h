// Draws the pictures of a ledger and reads them back, so that `sideray compare` of two of them gives the same. Main
// thread.
#pragma once

#include "cli/chart/chart_folder.h"
#include "cli/plan/ledger_shortcuts.h"
#include "cli/session/session.h"

namespace sideray::cli {

class LedgerPictures {
 public:
  // Number of pictures that random ones are averaged from.
  static constexpr uint32_t random_pictures = 8;

  LedgerPictures(const ChartOptions& options, const ChartFolder& folder, Session& session);

  static std::string file_of(const std::string& name);  // relative to the folder
  // Returns the given configuration, which all others are derived from.
  const RenderOptions& base() const { return base_; }
  Shortcuts find_shortcuts();

  // Draws with options other than those of base(). Throws Error.
  scenes::Image draw(const Shortcut& other);

  // Returns 1 where the reference sees another opaque triangle than the rasterizer, or only one of them sees any; for
  // the first position of each pixel.
  std::vector<uint8_t> differing_pixels();

  // Returns the chart's own reference, unless base() has other light transport.
  lab::ChartReference draw_reference(const lab::ChartReference& of_chart);

 private:
  RenderOptions reference_options() const;
  // Does the same, with the options of the chain's step.
  RenderOptions reference_options(const Shortcut& other) const;
  // Adds the step from one bounce to the number that the reference follows, which no method of drawing can take.
  void add_bounces(Shortcuts& shortcuts) const;
  // Counts wrong matches: there is no better matcher than ids to switch to.
  void add_match(Shortcuts& shortcuts);
  scenes::Image write(const std::string& name, const std::vector<scenes::Plane>& colour, uint32_t pictures) const;
  RenderOptions resolve(const lab::Configuration& configuration, const std::string& name) const;

  const ChartOptions& options_;
  const ChartFolder& folder_;
  Session& session_;
  RenderOptions base_;
};

}  // namespace sideray::cli
