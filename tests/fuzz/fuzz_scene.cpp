#include "fuzz/scene_promises.h"

// The glTF loader, binary or JSON by what the input begins with.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sideray::fuzz::load_and_use({data, size});
  return 0;
}
