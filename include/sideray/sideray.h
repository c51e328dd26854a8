/* Sideray: a ray-tracing side service for OpenGL rasterizers. C99 interface; its headers are the manual.
 *
 *   scene.h     sideray_scene: meshes, instances, materials, textures, lights, environment. Plain memory, no OpenGL.
 *   fixed_function.h  the fixed function of OpenGL 1.x as the light and material model of a scene.
 *   tracer.h    sideray_tracer: traces a committed scene. Plain memory in, plain memory out, no OpenGL.
 *   service.h   sideray_service: moves depth, stencil and results between a host's OpenGL context and a tracer.
 *   renderer.h  sideray_renderer: draws whole pictures, in a headless context of its own or in a host's.
 *   options.h   sideray_options: the options of pictures by name.
 * This header includes all of them. Not included are ground_truth.h, plan.h, diagnostics.h and scenes.h, whose library
 * is separate.
 *
 * Conventions of the whole interface
 * - Errors are values: a call that can fail returns a sideray_status and, where the caller passes one, fills a
 *   sideray_error whose message says what was wrong, where, and what to do. `error` may always be NULL.
 *   No call throws, exits, aborts, prints, or touches errno. A failed call changes nothing.
 * - Structs that callers fill begin with `size`, which is sizeof(the struct) as the caller was compiled; their *_defaults
 *   function sets it. They grow only at their end: the missing fields of a smaller struct have their defaults, and a
 *   larger struct is accepted if all bytes that the library does not know are 0. Structs that the library fills are
 *   filled up to their `size`. Arrays of structs have strides, or the `size` of their first element.
 * - Spaces: right-handed world, any unit (call it metre), column vectors, matrices in column-major order.
 *   `a_from_b` maps b to a. Angles in radians unless a name ends in _deg. Colours are linear Rec.709.
 * - Images: row 0 is the bottom row, as in OpenGL, unless a comment says otherwise.
 * - Objects are reference-counted: *_create returns one reference, *_retain adds one, *_release gives one back.
 * - Threads: a scene may be edited by one thread at a time; committed snapshots are immutable and shared freely.
 *   Calls on one tracer, service or renderer must not overlap. Only service and renderer calls touch OpenGL.
 */
#ifndef SIDERAY_SIDERAY_H
#define SIDERAY_SIDERAY_H

#include <sideray/base.h>
#include <sideray/fixed_function.h>
#include <sideray/options.h>
#include <sideray/renderer.h>
#include <sideray/scene.h>
#include <sideray/service.h>
#include <sideray/tracer.h>

#endif
