// One product of a run (a picture, a row of a chart, a case), and whether it exists. Plain memory; any thread.
#pragma once

#include "cli/record/run_record.h"

namespace sideray::cli {

struct RunPart {
  Json name;                    // number of a frame or row, otherwise a name
  uint32_t shard = 0;           // the shard that makes it
  std::string file;             // the file whose presence proves it
  std::string program, device;  // that made it; program "": missing or incomplete
};

}  // namespace sideray::cli
