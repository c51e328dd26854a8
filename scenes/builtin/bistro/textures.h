// Paints the bistro's textures: each call adds one to the content. Any thread.
#pragma once

#include "scenes/builtin/bistro/bistro.h"

namespace sideray::scenes::bistro {

Maps paint_floor(ContentBuilder& b);
Maps paint_wood(ContentBuilder& b);
Maps paint_plaster(ContentBuilder& b);
Maps paint_cobbles(ContentBuilder& b);
Maps paint_ashlar(ContentBuilder& b);
Maps paint_weave(ContentBuilder& b);
Maps paint_leather(ContentBuilder& b);
Maps paint_leaf(ContentBuilder& b);
Maps paint_cane(ContentBuilder& b);
uint32_t paint_label(ContentBuilder& b, int which);  // 0..3
uint32_t paint_chalkboard(ContentBuilder& b);
uint32_t paint_sign(ContentBuilder& b);
uint32_t paint_sky(ContentBuilder& b);
uint32_t paint_lit_window(ContentBuilder& b);
uint32_t paint_painting(ContentBuilder& b, int which);  // 0..2

}  // namespace sideray::scenes::bistro
