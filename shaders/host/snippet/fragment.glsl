// A fragment that looks for its layer: its place, and how far its distance may be from the layer's.

// In a multisampled target a fragment is shaded at the pixel's middle, even if its triangle covers other samples only.
// Its position then lies on the triangle's plane, up to half a pixel outside the triangle, where rays hit the
// neighbouring triangle. The two distances differ by the difference of both slopes. If the triangles are tilted by at
// most 45 degrees against each other, that is less than the fragment's own slope plus a pixel's breadth.
float sideray_beside(float slope, float breadth) { return sideray_has_samples() ? slope + breadth : 0.0; }

// Returns how far the rasterizer's distance d of this fragment may be from the ray's: the slope times how far vertices
// snap, plus rounding. Surfaces twice this apart are never confused; a looser bound would let the inner wall of a thin
// glass take the outer wall's layer. Needs derivatives of world_position.
// `beside`: by how much the distance changes to the neighbouring pixel, and the pixel's breadth at the surface.
float sideray_tolerance(vec3 world_position, float d, out vec2 beside) {
  float coordinates = max(sideray_largest(world_position), sideray_largest(sideray_eye.xyz));
  float slope, breadth;
  float moved = sideray_subpixel;
  if (sideray_eye.w > 0.5) {
    // On a plane in perspective 1 / depth and position / depth are linear in the picture, so their derivatives are
    // exact. Those of the distance are not, at glancing angles.
    vec3 from_eye = world_position - sideray_eye.xyz;
    float inverse_depth = 1.0 / dot(from_eye, sideray_near_plane.xyz);
    vec3 ray = from_eye * inverse_depth;
    float square = dot(ray, ray);
    slope = d * (abs(dot(ray, dFdx(ray)) / square - dFdx(inverse_depth) / inverse_depth) +
                 abs(dot(ray, dFdy(ray)) / square - dFdy(inverse_depth) / inverse_depth));
    // Positions far from their origin (in world space, say) are also rounded across the ray.
    moved += max(coordinates - 4.0 * d, 0.0) * 2.384e-7 * inverse_depth / length(dFdx(ray));
    breadth = length(dFdx(ray)) / abs(inverse_depth);
  } else {
    slope = fwidth(d);
    breadth = length(dFdx(world_position) - sideray_near_plane.xyz * dFdx(d));
  }
  beside = vec2(slope, breadth);
  return slope * moved + sideray_rounding(world_position, d) + sideray_beside(slope, breadth);
}

// Describes a fragment for its search in the cache.
struct SiderayFragment {
  ivec2 pixel;  // of the cache
  vec3 position, normal;  // of its plane; normal: unit, either side
  float distance;
  float tolerance, older_tolerance;  // of the distance, at the fragment's own pixel
  SIDERAY_UINT surface_id;
};

// Returns the distance at which the view ray meets the fragment's plane. On large polygons, which begin behind the eye
// and end far away, drivers interpolate positions coarsely: on the plane, but up to several pixels beside the ray.
float sideray_on_ray(SiderayFragment f) {
  bool perspective = sideray_eye.w > 0.5;
  vec3 along = sideray_ray_from_pixel * vec3(f.pixel, 1.0);
  vec3 origin = perspective ? sideray_eye.xyz : along;
  vec3 direction = perspective ? normalize(along) : sideray_eye.xyz;
  float farther = dot(f.normal, f.position - origin - direction * f.distance) / dot(f.normal, direction);
  // Triangles without an area have no plane.
  return abs(farther) <= 0.5 * f.distance ? f.distance + farther : f.distance;
}

// Needs derivatives: call it in uniform control flow.
SiderayFragment sideray_fragment(vec3 world_position, SIDERAY_UINT surface_id) {
  SiderayFragment f;
  f.pixel = sideray_pixel();
  f.position = world_position;
  f.normal = normalize(cross(dFdx(world_position), dFdy(world_position)));
  f.distance = sideray_distance_to(world_position);
  vec2 beside;
  f.tolerance = sideray_tolerance(world_position, f.distance, beside);
  f.distance = sideray_on_ray(f);
  f.older_tolerance = f.tolerance + 0.125 * length(beside);
  f.surface_id = surface_id;
  return f;
}

// Intersects the view ray of `pixel` with the fragment's plane. x = the distance, at most 0 where they do not meet; y =
// the tolerance for a layer of the same surface. Distances of different pixels are not compared directly, since at
// glancing angles they differ by more than surfaces do. Along the plane's normal, y allows rounding and, for curvature,
// an eighth of the distance between the two pixels' rays: a surface seen at angle i that turns by cos(i) / 4 per pixel
// leaves its tangent plane by half that turn times the 1 / cos(i) between its two points.
vec2 sideray_meet_plane(SiderayFragment f, ivec2 pixel) {
  vec3 along = sideray_ray_from_pixel * vec3(pixel, 1.0);
  bool perspective = sideray_eye.w > 0.5;
  vec3 origin = perspective ? sideray_eye.xyz : along;
  vec3 direction = perspective ? normalize(along) : sideray_eye.xyz;
  float toward = dot(f.normal, direction);
  float apart = distance(origin + direction * f.distance, f.position);
  float off_plane = apart * 0.125 + sideray_rounding(f.position, f.distance);
  return vec2(dot(f.normal, f.position - origin) / toward, off_plane / abs(toward));
}
