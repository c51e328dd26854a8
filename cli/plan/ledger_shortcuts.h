// Which shortcuts a configuration takes, and what switches each of them off (docs/ledger.md). Any thread.
#pragma once

#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"
#include "scenes/content/content.h"

namespace sideray::cli {

struct Shortcut {
  std::string name;        // as in ledger.json and ledger.exr
  std::string what;        // what was done, and what instead
  lab::Configuration off;  // the options that switch it off
  bool is_random = false;  // its opposite is a mean over random numbers
  bool is_exact = false;   // its opposite is sideray_renderer_set_exact_points
};

struct Unsplit {
  std::string name, reason;
};

struct Shortcuts {
  std::vector<Shortcut> taken;
  std::vector<Shortcut> chain;  // all of them off, and from there on towards the reference
  std::vector<Unsplit> inseparable;
  std::vector<Unsplit> absent;
};

struct LedgerScene {
  const scenes::Content* content;
  size_t layered;      // objects that `--ray-traced` of the configuration gives layers
  size_t all_layered;  // that `--ray-traced all` would
};

Shortcuts shortcuts_of(const RenderOptions& base, const LedgerScene& scene);

}  // namespace sideray::cli
