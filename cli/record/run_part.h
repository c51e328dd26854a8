// One thing that a run makes (a picture, a row of a chart, a case), and what of it is there. Plain memory; any thread.
#pragma once

#include "cli/record/run_record.h"

namespace sideray::cli {

struct RunPart {
  Json name;                    // the number of a frame or row, else a name
  uint32_t shard = 0;           // whose task makes it
  std::string file;             // the file it is known by
  std::string program, device;  // that made it; program "": it is missing, or not whole
};

}  // namespace sideray::cli
