// Draws sprites: squares parallel to the picture, one for each instance. Defines: SR_LIT (colour is an albedo),
// SR_COVERAGE (only the position).
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_half_size;
layout(location = 2) in vec2 in_turn;  // cosine and sine of the rotation
layout(location = 3) in vec4 in_color;
layout(location = 4) in uint in_cell;

uniform mat4 clip_from_local;
uniform vec3 camera_x, camera_y;
uniform vec4 depth_from_local;  // along the view axis, from the eye

#ifndef SR_COVERAGE
uniform ivec2 flip_book;    // columns and rows
uniform vec2 cell_texels;
uniform float last_level;
uniform vec2 pixel_at_depth;  // world units of a pixel: x + y * depth

out vec2 v_corner;  // 0..1 each way, from the top left of the cell
flat out vec4 v_color;
flat out vec2 v_cell;
flat out float v_level;
flat out float v_depth;
#ifdef SR_REFRACTED
out vec3 v_position;
#endif
#endif
#if SR_ORDER != 0
flat out uint v_instance;
#endif

void main() {
  vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  vec2 offset = side * in_half_size;
  vec2 turned = vec2(in_turn.x * offset.x - in_turn.y * offset.y, in_turn.y * offset.x + in_turn.x * offset.y);
  vec3 position = in_position + camera_x * turned.x + camera_y * turned.y;
  gl_Position = clip_from_local * vec4(position, 1.0);
#ifdef SR_REFRACTED
  v_position = position;
#endif
#ifndef SR_COVERAGE
  v_corner = vec2(0.5, 0.5) + vec2(0.5, -0.5) * side;
  v_cell = vec2(int(in_cell) % flip_book.x, int(in_cell) / flip_book.x);
  v_depth = dot(depth_from_local, vec4(in_position, 1.0));
  v_level = sr_sprite_level(cell_texels, 2.0 * in_half_size, pixel_at_depth.x + pixel_at_depth.y * v_depth, last_level);
  v_color = in_color;
#if SR_ORDER != 0
  v_instance = uint(gl_InstanceID);
#endif
#ifdef SR_LIT
  vec3 to_eye = direction_to_eye(in_position);
  v_color.xyz *= radiance_from(sr_sprite(vec4(1.0), to_eye, true, 1.0, 0), in_position, to_eye);
#endif
#endif
}
