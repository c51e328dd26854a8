/* Passes the engine's quads to Sideray. */
#ifndef MINIMAL_HOST_QUADS_H
#define MINIMAL_HOST_QUADS_H

#include <sideray/sideray.h>

/* Ends the program with the library's message if `status` is an error. */
void sideray_require(sideray_status status, const sideray_error* error);

/* `quad`: 0 is the floor, 1 the glass. */
void add_quad(sideray_scene* scene, int quad, const sideray_material_desc* desc, uint32_t surface_id);

#endif
