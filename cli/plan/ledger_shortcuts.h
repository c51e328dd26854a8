// Lists the shortcuts that a configuration takes, and what switches each of them off (docs/ledger.md). Any thread.
#pragma once

#include <sideray/plan.h>

#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

struct Shortcut {
  std::string name;        // as in ledger.json and ledger.exr
  std::string what;        // what was done, and what instead
  lab::Configuration off;  // the options that switch it off
  bool is_random = false;  // its opposite is a mean over random numbers
  bool is_exact = false;   // its opposite is sideray_diagnostics::exact_points
};

// Returns whether its opposite is a reference.
inline bool is_reference(const Shortcut& shortcut) {
  return shortcut.off.contains("reference");
}

struct Unsplit {
  std::string name, reason;
};

struct Shortcuts {
  std::vector<Shortcut> taken;
  std::vector<Shortcut> chain;  // all of them off, and from there on towards the reference
  std::vector<Unsplit> inseparable;
  std::vector<Unsplit> absent;
};

// `facts`: the scene's, with the layers that the options give it. Throws Error.
Shortcuts shortcuts_of(const RenderOptions& base, const sideray_scene_facts& facts);

}  // namespace sideray::cli
