// Temporal anti-aliasing: averages the picture with the history, whose pictures have other jitter and are reprojected
// by the motion of the opaque surface (at edges, of the nearest surface beside them). History is clipped to mean and
// variance of the neighbourhood (Salvi 2016, An Excursion in Temporal Supersampling), bright colours have less weight
// (Karis 2014, High-Quality Temporal Supersampling), and history is filtered by Catmull-Rom in five lookups (Jimenez
// 2016, Filmic SMAA).
layout(location = 0) out vec4 o_picture;
layout(location = 1) out vec2 o_state;  // distance along the view axis; number of pictures in the average

uniform sampler2D temporal_picture;  // this frame's
uniform sampler2D temporal_motion;
uniform sampler2D history_picture;   // linear
uniform sampler2D history_state;
uniform sampler2D gbuffer_depth;
uniform bool has_history;
uniform float least_pictures;        // number of pictures in the history, at least
uniform bool reversed_depth;
uniform vec2 clip_z_from_depth;             // factor, offset
uniform vec4 distance_now, distance_before;  // in clip space: distance along the axis of the view, times `share`
uniform vec4 share;

const float infinitely_far = 1e30;
const float largest_half = 65504.0;
const float least_weight = 0.1;        // of this frame
const float deviations = 1.25;         // that history may differ by
const float same_distance = 0.9;       // nearer than this share: another surface in front
const float weight_of_brightness = 16.0;  // relative to the neighbourhood's

float luminance(vec3 c) {
  return dot(c, vec3(0.2126, 0.7152, 0.0722));
}

vec3 ycocg(vec3 c) {
  return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

vec3 rgb(vec3 c) {
  return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// Removes infinities, which would never fade from history.
vec4 picture_at(ivec2 pixel) {
  vec4 c = texelFetch(temporal_picture, clamp(pixel, ivec2(0), textureSize(temporal_picture, 0) - 1), 0);
  return vec4(c.x > 0.0 ? min(c.x, largest_half) : 0.0, c.y > 0.0 ? min(c.y, largest_half) : 0.0,
              c.z > 0.0 ? min(c.z, largest_half) : 0.0, c.w > 0.0 ? min(c.w, 1.0) : 0.0);
}

float depth_at(ivec2 pixel) {
  return texelFetch(gbuffer_depth, clamp(pixel, ivec2(0), textureSize(gbuffer_depth, 0) - 1), 0).x;
}

float distance_of(ivec2 pixel, float depth, vec4 axis) {
  if (depth == (reversed_depth ? 0.0 : 1.0)) return infinitely_far;
  vec2 place = (vec2(pixel) + 0.5) * 2.0 / vec2(textureSize(gbuffer_depth, 0)) - 1.0;
  vec4 clip = vec4(place, depth * clip_z_from_depth.x + clip_z_from_depth.y, 1.0);
  float part = dot(share, clip);
  return part > 0.0 ? min(dot(axis, clip) / part, infinitely_far) : infinitely_far;
}

// Returns the nearest of the pixel and its diagonal neighbours.
ivec2 nearest_pixel(ivec2 pixel, out float depth) {
  ivec2 nearest = pixel;
  depth = depth_at(pixel);
  for (int i = 0; i < 4; ++i) {
    ivec2 beside = pixel + ivec2(2 * (i & 1) - 1, (i & 2) - 1);
    float other = depth_at(beside);
    if (reversed_depth ? other > depth : other < depth) depth = other, nearest = beside;
  }
  return clamp(nearest, ivec2(0), textureSize(gbuffer_depth, 0) - 1);
}

// Returns whether everything in the history there is clearly in front of the current surface, which was thus hidden.
bool was_hidden(vec2 texel, float distance) {
  ivec2 last = textureSize(history_state, 0) - 1, at = ivec2(floor(texel));
  float farthest = texelFetch(history_state, clamp(at, ivec2(0), last), 0).x;
  for (int i = 0; i < 4; ++i)
    farthest = max(farthest, texelFetch(history_state, clamp(at + ivec2(2 * (i & 1) - 1, (i & 2) - 1), ivec2(0), last), 0).x);
  return farthest < same_distance * distance;
}

vec4 history_at(vec2 texel) {
  vec2 size = vec2(textureSize(history_picture, 0));
  vec2 middle = floor(texel - 0.5) + 0.5, f = texel - middle;
  vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f)), w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
  vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f)), w3 = f * f * (-0.5 + 0.5 * f);
  vec2 w12 = w1 + w2;
  vec2 at0 = (middle - 1.0) / size, at3 = (middle + 2.0) / size, at12 = (middle + w2 / w12) / size;
  // Omits the four corners, whose weights are small.
  vec4 sum = texture(history_picture, vec2(at12.x, at0.y)) * (w12.x * w0.y) +
             texture(history_picture, vec2(at0.x, at12.y)) * (w0.x * w12.y) +
             texture(history_picture, at12) * (w12.x * w12.y) +
             texture(history_picture, vec2(at3.x, at12.y)) * (w3.x * w12.y) +
             texture(history_picture, vec2(at12.x, at3.y)) * (w12.x * w3.y);
  float weight = w12.x * w0.y + w0.x * w12.y + w12.x * w12.y + w3.x * w12.y + w12.x * w3.y;
  return max(sum / weight, 0.0);
}

struct Neighbourhood {
  vec3 mean, deviation;  // YCoCg
  float least_alpha, largest_alpha;
};

Neighbourhood neighbourhood_of(ivec2 pixel) {
  vec3 sum = vec3(0.0), squares = vec3(0.0);
  float least = 1.0, largest = 0.0;
  for (int i = 0; i < 9; ++i) {
    vec4 picture = picture_at(pixel + ivec2(i % 3 - 1, i / 3 - 1));
    vec3 c = ycocg(picture.rgb);
    sum += c, squares += c * c;
    least = min(least, picture.a), largest = max(largest, picture.a);
  }
  vec3 mean = sum / 9.0;
  return Neighbourhood(mean, sqrt(max(squares / 9.0 - mean * mean, 0.0)), least, largest);
}

// Moves a colour toward the mean until it is inside.
vec3 clipped(vec3 c, Neighbourhood n) {
  vec3 off = c - n.mean, units = abs(off) / max(deviations * n.deviation, 1e-6 + 1e-4 * abs(n.mean.x));
  return n.mean + off / max(1.0, max(units.x, max(units.y, units.z)));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 now = picture_at(pixel);
  float own_depth = depth_at(pixel);
  o_picture = now;
  o_state = vec2(distance_of(pixel, own_depth, distance_now), 1.0);
  if (!has_history) return;
  float depth;
  ivec2 mover = nearest_pixel(pixel, depth);
  vec2 before = gl_FragCoord.xy - texelFetch(temporal_motion, mover, 0).xy;
  vec2 size = vec2(textureSize(history_picture, 0));
  if (any(lessThan(before, vec2(0.0))) || any(greaterThanEqual(before, size))) return;
  if (was_hidden(before, distance_of(mover, depth, distance_before))) return;
  Neighbourhood n = neighbourhood_of(pixel);
  vec4 past = history_at(before);
  past = vec4(max(rgb(clipped(ycocg(past.rgb), n)), 0.0), clamp(past.a, n.least_alpha, n.largest_alpha));
  float pictures = max(texelFetch(history_state, ivec2(before), 0).y, least_pictures) + 1.0;
  float weight = max(least_weight, 1.0 / pictures);
  float scale = 1.0 / (weight_of_brightness * n.mean.x + 1e-6);
  float of_now = weight / (1.0 + luminance(now.rgb) * scale);
  float of_past = (1.0 - weight) / (1.0 + luminance(past.rgb) * scale);
  vec3 mixed = (now.rgb * of_now + past.rgb * of_past) / (of_now + of_past);
  o_picture = vec4(min(mixed, vec3(largest_half)), mix(past.a, now.a, weight));
  o_state.y = min(pictures, 1.0 / least_weight);
}
