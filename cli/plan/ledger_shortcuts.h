// Lists the shortcuts of a configuration, and the options that switch each off (docs/ledger.md). Any thread.
#pragma once

#include <sideray/plan.h>

#include "cli/options/render_options.h"
#include "lab/chart/configurations.h"

namespace sideray::cli {

struct Shortcut {
  std::string name;        // as in ledger.json and ledger.exr
  std::string what;        // what was done, and what is done instead
  lab::Configuration off;  // the options that switch it off
  bool is_random = false;  // without it, the picture is a mean over random numbers
  bool is_exact = false;   // without it, sideray_diagnostics::exact_points is set
};

// Returns whether the picture without the shortcut is a reference.
inline bool is_reference(const Shortcut& shortcut) {
  return shortcut.off.contains("reference");
}

struct Unsplit {
  std::string name, reason;
};

struct Shortcuts {
  std::vector<Shortcut> taken;
  std::vector<Shortcut> chain;  // all of them off, and from there towards the reference
  std::vector<Unsplit> inseparable;
  std::vector<Unsplit> absent;
};

// `facts`: of the scene, with the layers that the options select. Throws Error.
Shortcuts shortcuts_of(const RenderOptions& base, const sideray_scene_facts& facts);

}  // namespace sideray::cli
