// What a check says of one picture. Any thread.
#pragma once

#include <string>

#include "cli/golden/golden_jobs.h"
#include "lab/golden/changes.h"

namespace sideray::cli {

struct Verdict {
  GoldenPicture drawn, reference;
  lab::Differences differences;
  lab::Display display;
  bool holds = true;  // equal, or within the drift that was approved for this driver
  std::string text;   // "equal", or what differs
  double seconds = 0;

  Drift drift() const;
};

// `reference`: the picture and the ids of `recorded`.
Verdict verdict_on(DrawnPicture&& drawn, const GoldenPicture& recorded, const scenes::Image& reference,
                   const scenes::Image& ids);

// One page for all, with the pictures that differ: those of the folder `drawn` beside those of `references`.
std::string golden_page_text(const std::string& title, const std::string& summary, const std::vector<Verdict>& verdicts,
                             const std::string& drawn, const std::string& references);

}  // namespace sideray::cli
