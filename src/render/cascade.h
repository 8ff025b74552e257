/* Fitting: where the layers of a light's map look. Pure functions of cameras, bounds and lights.
 *
 * Light space has the axes of gn_light_axes() through the world's origin, so that a place in it
 * depends neither on the camera nor on the scene. */
#ifndef GN_RENDER_CASCADE_H
#define GN_RENDER_CASCADE_H

#include "cpu/map.h"

typedef struct gn_bounds {
    double low[3], high[3]; /* empty where low > high */
} gn_bounds;

/* Unit vectors at right angles, right x up = -forward. */
typedef struct gn_axes {
    double right[3], up[3], forward[3];
} gn_axes;

/* Axes of a light that shines along direction (unit length). They turn smoothly with it everywhere
 * but where it shines straight up: a sun through the zenith does not turn its map over. */
gn_axes gn_light_axes(const float direction[3]);

/* Cascades ------------------------------------------------------------------------------------*/

/* A camera's view of a scene, cut into slices. */
typedef struct gn_cascades {
    float direction[3];                     /* of the light */
    gn_axes light, camera;                  /* camera: forward is where it looks */
    double eye[3], half_width, half_height; /* of the view: tangents, or metres */
    bool orthographic;
    gn_bounds bounds; /* of the scene, in the world */
    gn_bounds scene;  /* the same in light space */
    double slack;     /* share by which boxes that follow the bounds are larger: they may move */
    double enlarge;
    uint32_t resolution, margin;
    uint32_t count;                   /* slices that have something to hold; 0: nothing in view */
    double ends[GN_MAX_CASCADES + 1]; /* slice i: [ends[i], ends[i + 1]] along the camera's axis */
} gn_cascades;

/* desc: checked. margin: texels that a level keeps free at its border; resolution > 2 margin + 2.
 * moving: may the bounds change from frame to frame?
 *
 * Both ends of what is seen are rounded outwards to a step of 19 %, so that small movements of the
 * camera change no slice. The logarithmic part of the split starts no nearer than a thousandth of
 * the far end; an orthographic view is split evenly, since all of its pixels are of one size. */
gn_cascades gn_cascades_make(const gn_camera *camera, float aspect, const float bounds_min[3],
                             const float bounds_max[3], bool moving, const float direction[3],
                             const gn_map_desc *desc, uint32_t margin);

/* The same view under another light. */
gn_cascades gn_cascades_turned(const gn_cascades *cascades, const float direction[3]);

/* The box in light space of slice i of the view inside the scene's bounds. */
gn_bounds gn_cascade_need(const gn_cascades *cascades, uint32_t i);

/* A level in its place. */
typedef struct gn_cascade {
    gn_map_projection projection;
    float direction[3]; /* of the light that it was placed for */
    gn_bounds box;      /* in that light's space: what it holds, margin taken off */
    bool whole;         /* it holds the scene: no level is needed behind it */
} gn_cascade;

/* Places the level of slice i. Its size depends on the slice alone: the sphere around it, enlarged,
 * or the scene's square where that is smaller; in depth, the same size or the scene's. Its texels
 * lie on a grid through the origin of light space. */
gn_cascade gn_cascade_fit(const gn_cascades *cascades, uint32_t i);

/* The same for a level that will be ready after some updates only: it lies as far towards slice i
 * of the view `ahead`, under the same light, as it can while it holds slice i as it is. */
gn_cascade gn_cascade_fit_ahead(const gn_cascades *cascades, const gn_cascades *ahead, uint32_t i);

/* Can a level that was placed for an earlier view serve slice i? (Leak tracing paper, section 3.3:
 * it holds what the slice needs.) It must also not be twice as large as the slice asks for. */
bool gn_cascade_serves(const gn_cascade *placed, const gn_cascades *cascades, uint32_t i);

/* Does a level hold something of slice i, where there is anything to hold? */
bool gn_cascade_meets(const gn_cascade *placed, const gn_cascades *cascades, uint32_t i);

/* Texels by which shadows may lie off in a level that was placed for another direction: as far as
 * a caster can be before what it shades, inside the scene's bounds, times the tangent of the angle.
 * INFINITY at right angles and beyond. */
double gn_cascade_shift(const gn_cascade *placed, const gn_cascades *cascades,
                        const float direction[3]);

/* Lamps ---------------------------------------------------------------------------------------*/

/* Radians, a little over 75 degrees: spot lights with a larger half angle get six faces. */
#define GN_SPOT_MAX_ANGLE 1.31

/* One view along a spot light, or six around a point light (and a spot light that is too wide).
 * Faces overlap by the margin, so that reading at their edges finds a face that holds all its
 * texels. Depth of faces is the largest coordinate's: it continues over the edges of the cube. */
typedef struct gn_lamp {
    uint32_t count;
    double near, far; /* what must be reached; faces reach further where the bounds may move */
    gn_map_projection faces[6];
} gn_lamp;

gn_lamp gn_lamp_make(const gn_light *light, const float bounds_min[3], const float bounds_max[3],
                     bool moving, const gn_map_desc *desc, uint32_t margin);

/* Can a face that was placed for the same light in an earlier frame serve now? */
bool gn_lamp_serves(const gn_map_projection *placed, const gn_lamp *now);

/* Is some of a box of the world between the sides of a projection, and before its far end
 * (perspective: and behind its near end)? May say yes to a box outside. */
bool gn_projection_sees(const gn_map_projection *projection, const gn_bounds *box);

#endif
