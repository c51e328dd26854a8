/* Adds the engine's quads to a scene of Sideray. */
#ifndef MINIMAL_HOST_QUADS_H
#define MINIMAL_HOST_QUADS_H

#include <sideray/sideray.h>

/* Ends the program with the library's message if a call has failed. */
void sideray_require(sideray_status status, const sideray_error* error);

/* Adds a quad: 0 = the floor, 1 = the glass. */
void add_quad(sideray_scene* scene, int quad, const sideray_material_desc* desc, uint32_t surface_id);

#endif
