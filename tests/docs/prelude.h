/* Declares the engine's names to which code in the documents refers. C99 and C++20. */
#include <sideray/diagnostics.h>
#include <sideray/plan.h>
#include <sideray/scenes.h>
#include <sideray/sideray.h>
#include <stdio.h>

#ifdef __cplusplus
#include <sideray/scenes.hpp>
#include <sideray/sideray.hpp>
#endif

struct face {
  float reflects;
};
void light_surface(void* engine, const struct face* face, const float* uv, const float* light_uv, const float* normal,
                   const float* to_eye, float* radiance);
void* get_proc_address(void* user, const char* name);
void draw_gbuffer(void);
void draw_glass_mask(void);
void draw_sky(void);
void light_opaque_surfaces(void);
void draw_glass(void);
void use_texture_array(uint32_t texture);
void set_previous_matrix(const double* world_from_object);
void write_plane(const char* name, const void* values);
void add_to_settings_page(const char* name, const char* help, const char* value);

extern void* engine;
extern const float* positions;
extern const uint32_t* indices;
extern uint32_t vertex_count, index_count, frame_number, framebuffer, first_unit, light_program, glass_program;
extern int32_t width, height;
extern double matrices[24];

extern sideray_error error;
extern sideray_scene* scene;
extern sideray_mesh splinters;
extern sideray_instance instance, instances[2];
extern sideray_instance_desc descs[2];
extern sideray_tracer* tracer;
extern sideray_ray rays[4];
extern sideray_hit hits[4];
extern sideray_service* service;
extern sideray_host_gl host;
extern sideray_view view, views[2];
extern sideray_layer_inputs layers;
extern sideray_frame_inputs frame;
extern sideray_ticket ticket, second_wave, tickets[2];
extern sideray_renderer* renderer;
extern sideray_camera camera;
extern sideray_picture* picture;
