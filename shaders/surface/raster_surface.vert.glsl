// Vertex stage of every pass that draws surfaces: one text and an invariant position, so that the passes agree bit for
// bit. Defines: SR_ALPHA (outputs uv and colour), SR_SHADED (everything), SR_LOCATED (the position), SR_WIND (wind
// moves vertices; included after wind.h), SR_REST (where rays hit), SR_MOTION (positions in the frame before).
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;
layout(location = 6) in vec3 in_local_x;  // columns of local_from_object
layout(location = 7) in vec3 in_local_y;
layout(location = 8) in vec3 in_local_z;
layout(location = 9) in vec3 in_local_origin;
layout(location = 10) in vec3 in_normal_x;  // columns of its inverse transpose
layout(location = 11) in vec3 in_normal_y;
layout(location = 12) in vec3 in_normal_z;
layout(location = 13) in uvec2 in_id_traits;  // surface id; 1 mirrored, 2 solid
#ifdef SR_WIND
layout(location = 14) in float in_wind_phase;
#endif
#ifdef SR_MOTION
layout(location = 15) in vec3 in_position_before;  // where is_shaped_before is set
#endif

uniform mat4 clip_from_local;
#ifdef SR_WIND
uniform vec4 wind_direction_amplitude;
uniform vec4 wind_sizes;   // height, branch amplitude, leaf amplitude, wavelength
uniform vec3 wind_cycles;  // of trunk, branches and leaves, 0..1; in_wind_phase is added
#endif

invariant gl_Position;
#if defined(SR_LOCATED) || defined(SR_SHADED)
out vec3 v_position;
#endif
#if defined(SR_ALPHA) || defined(SR_SHADED)
out vec4 v_uv;  // both sets
out vec4 v_color;
#endif
#ifdef SR_SHADED
out vec3 v_normal;
out vec4 v_tangent;
flat out uint v_surface_id;
flat out uint v_solid;
#endif

#ifdef SR_REST
// Offset from the drawn vertex to where rays hit it, and the most that wind moves it; world units.
out vec4 v_rest;
uniform uint rest_poses;  // number of shared poses: 0 = the neutral one, 0xffffffff = each instance has its own
#endif

#ifdef SR_MOTION
// Clip space without jitter, x y w: interpolated in the same way, so that still surfaces have exactly no motion.
out vec3 v_now;
out vec3 v_before;
uniform mat4 still_from_local, before_from_local;
uniform bool is_placed_before;  // the transform has changed
uniform bool is_shaped_before;  // the mesh's vertices have moved
uniform mat4 local_before_from_object;
#ifdef SR_WIND
uniform vec3 wind_cycles_before;
#endif
#endif

#ifdef SR_WIND
SrWind wind_here() {
  return SrWind(wind_direction_amplitude.xyz, wind_direction_amplitude.w, wind_sizes.x, wind_sizes.y, wind_sizes.z,
                wind_sizes.w);
}

vec3 moved_in(vec3 cycles, float phase) {
  return sr_wind(wind_here(),
                 SrWindPhase(sr_fract(cycles.x + phase), sr_fract(cycles.y + phase), sr_fract(cycles.z + phase)),
                 in_position);
}

vec3 moved_at(float phase) {
  return moved_in(wind_cycles, phase);
}
#endif

// Returns the vertex's current position in object space.
vec3 position_now() {
#ifdef SR_WIND
  return in_position + moved_at(in_wind_phase);
#else
  return in_position;
#endif
}

void main() {
  vec3 position = position_now();
  vec3 local = in_local_x * position.x + in_local_y * position.y + in_local_z * position.z + in_local_origin;
  gl_Position = clip_from_local * vec4(local, 1.0);
#if defined(SR_LOCATED) || defined(SR_SHADED)
  v_position = local;
#endif
#ifdef SR_REST
  v_rest = vec4(0.0);
#ifdef SR_WIND
  // Chooses as rt/poses/foliage.cpp does: its own pose, the copy nearest in phase, or the neutral one.
  vec3 met = vec3(0.0);
  bool own = rest_poses == 0xffffffffu;
  if (own) {
    met = moved_at(in_wind_phase);
  } else if (rest_poses > 0u) {
    float copies = float(rest_poses);
    met = moved_at(mod(floor(sr_fract(in_wind_phase) * copies + 0.5), copies) / copies);
  }
  vec3 away = met - moved_at(in_wind_phase);
  float scale = max(length(in_local_x), max(length(in_local_y), length(in_local_z)));
  // Twice the range of wind where both ends move.
  float most = sr_wind_bound(wind_here(), in_position) * (own ? 0.0 : rest_poses == 0u ? 1.0 : 2.0);
  v_rest = vec4(in_local_x * away.x + in_local_y * away.y + in_local_z * away.z, most * scale);
#endif
#endif
#ifdef SR_MOTION
  vec3 old = is_shaped_before ? in_position_before : in_position;
#ifdef SR_WIND
  old += moved_in(wind_cycles_before, in_wind_phase);
#endif
  vec3 local_before = in_local_x * old.x + in_local_y * old.y + in_local_z * old.z + in_local_origin;
  if (is_placed_before) local_before = (local_before_from_object * vec4(old, 1.0)).xyz;
  v_now = (still_from_local * vec4(local, 1.0)).xyw;
  v_before = (before_from_local * vec4(local_before, 1.0)).xyw;
#endif
#if defined(SR_ALPHA) || defined(SR_SHADED)
  v_uv = vec4(in_uv0, in_uv1);
  v_color = in_color;
#endif
#ifdef SR_SHADED
  v_normal = in_normal_x * in_normal.x + in_normal_y * in_normal.y + in_normal_z * in_normal.z;
  vec3 tangent = in_local_x * in_tangent.x + in_local_y * in_tangent.y + in_local_z * in_tangent.z;
  // A mirroring transform reverses the frame's handedness.
  v_tangent = vec4(tangent, (in_id_traits.y & 1u) != 0u ? -in_tangent.w : in_tangent.w);
  v_surface_id = in_id_traits.x;
  v_solid = (in_id_traits.y >> 1) & 1u;
#endif
}
