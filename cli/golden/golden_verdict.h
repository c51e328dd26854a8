// Holds the verdict of a check on one picture. Any thread.
#pragma once

#include <string>

#include "cli/golden/golden_jobs.h"
#include "lab/golden/changes.h"

namespace sideray::cli {

struct Verdict {
  GoldenPicture drawn, reference;
  lab::Differences differences;
  lab::Display display;
  bool holds = true;  // equal, or within the bound approved for this driver
  std::string text;   // "equal", or the differences
  double seconds = 0;

  Drift drift() const;
};

// `reference`, `ids`: the picture and the ids of `recorded`.
Verdict verdict_on(DrawnPicture&& drawn, const GoldenPicture& recorded, const scenes::Image& reference,
                   const scenes::Image& ids);

// Returns one page for all verdicts, with the pictures that differ: from the folders `drawn` and `references`.
std::string golden_page_text(const std::string& title, const std::string& summary, const std::vector<Verdict>& verdicts,
                             const std::string& drawn, const std::string& references);

}  // namespace sideray::cli
