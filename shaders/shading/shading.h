// The shading model, once for raster fragments (GLSL) and ray hits (C++ scalars and SIMD lanes, through shading_cpp.h).
// Dialect: f suffixes, no swizzles, no in/out parameters, sr_select instead of branches on data, own type names. The
// includer defines real, real2, real3, real4, boolean, integer (a value a lane), one_real, one_real3 (the same for all
// lanes), SR_FN, sr_select, sr_any (whether a condition holds in some lane), sr_atan2.
// Model: metallic-roughness of glTF 2.0 (appendix B): GGX (Walter et al. 2007) with height-correlated Smith visibility
// (Heitz 2014), Schlick's Fresnel, Lambert; split-sum image-based lighting (Karis 2013); what is reflected more than
// once between microfacets leaves the surface as the rest does (Turquin 2019). A thin film (KHR_materials_iridescence:
// Belcour and Barla 2017) colours what the base reflects; the base's lobe may be longer along a direction of the surface
// than across it (KHR_materials_anisotropy). Above it, as in the glTF extensions: sheen
// (KHR_materials_sheen: Estevez and Kulla 2017), then clear coat (KHR_materials_clearcoat), each taking from what lies
// below what it reflects itself; below it, diffuse transmission (KHR_materials_diffuse_transmission).

#include "parts/surface.h"
#include "parts/film.h"
#include "parts/brushed.h"
#include "parts/seen.h"
#include "parts/lobes.h"
#include "parts/surroundings.h"
#include "parts/lights.h"
