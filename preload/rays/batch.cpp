#include "preload/rays/batch.h"

#include "preload/gl/functions.h"

namespace sideray::run {

void HeldDraw::make() const {
  if (list != 0) {
    real().CallList(list);
    return;
  }
  for (const Geometry* piece : geometry) run::draw(*piece);
}

}  // namespace sideray::run
